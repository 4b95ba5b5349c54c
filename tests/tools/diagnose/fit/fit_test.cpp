// The fit: derivatives, recovery of what was hidden with honest intervals, held-out energies.
#include "tools/diagnose/fit/fit.h"
#include "tools/diagnose/fit/quick_fit.h"

#include <gtest/gtest.h>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/fit/start.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr double kHidden = 0.06;  // N m

/// A pendulum that rubs more than its model says; `effects` may explain it.
SmallComparison rubbing(std::uint64_t seed, int count = 2,
                        const std::vector<std::string>& effects = {"coulomb_friction"}) {
  return compared(pendulum(kNoisyServo), {hidden("coulomb_friction", "a", {{"coulomb", kHidden}})},
                  effects, seed, count);
}

FitResult fitted(const SmallComparison& c, const Surroundings& around, double from) {
  return fit(around, with(c, c.of("coulomb_friction"), {from}), 7);
}

TEST(Fit, DerivativesAreThoseOfThePredictionError) {
  const SmallComparison c = rubbing(1, 2, {"viscous_friction"});
  ASSERT_GE(c.of("viscous_friction"), 0);
  const Model at = with(c, c.of("viscous_friction"), {0.05});
  const Surroundings around = make_surroundings(c.problem, c.library, at);
  const FitResult linear = fit(around, at, 0);
  ASSERT_EQ(linear.parameters, 1);
  const double typical = c.library[c.of("viscous_friction")].parameters[0].typical;
  Model more = at, less = at;
  more.effects[0].theta[0] += 0.01 * typical, less.effects[0].theta[0] -= 0.01 * typical;
  const Eigen::VectorXd slope = (prediction_error(c.problem, c.library, more) -
                                 prediction_error(c.problem, c.library, less)) /
                                0.02;
  EXPECT_LT((linear.J.col(0) - slope).norm(), 0.05 * slope.norm());
}

TEST(Fit, DerivativesByNuisancesAreToo) {
  const SmallComparison c = rubbing(1);
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  for (std::size_t k = 0; k < c.library.nuisances.size(); ++k) {
    Model more = nominal(c), less = nominal(c);
    const double step = 0.05 * c.library.nuisances[k].tolerance;
    more.nuisance[k] = step, less.nuisance[k] = -step;
    const Eigen::VectorXd slope = (prediction_error(c.problem, c.library, more) -
                                   prediction_error(c.problem, c.library, less)) /
                                  0.1;
    const auto col = around.A.col(k);
    EXPECT_LT((col - slope).norm(), 0.1 * slope.norm() + 0.5) << c.library.nuisances[k].name;
  }
}

TEST(Fit, RecoversWhatWasHiddenFromEitherSide) {
  const SmallComparison c = rubbing(1);
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  for (const double from : {0.02, 0.12}) {
    const FitResult f = fitted(c, around, from);
    EXPECT_NEAR(f.model.effects[0].theta[0], kHidden, 0.005) << from;
    EXPECT_TRUE(f.converged);
  }
}

TEST(Fit, RobustIntervalsHoldTheTruthAsOftenAsTheySay) {
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const SmallComparison c = rubbing(seed, 3);
    const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
    FitResult f = fitted(c, around, 0.04);
    f.covariance = robust_covariance(around, f, 1.0);
    const double sigma = parameter_sigmas(f, c.library)[0];
    EXPECT_LT(sigma, 0.01);
    inside += std::abs(f.model.effects[0].theta[0] - kHidden) < 2.5 * sigma;
  }
  EXPECT_GE(inside, 10) << "of 12";
}

TEST(Fit, NeverEndsAboveItsStart) {
  const SmallComparison c = rubbing(2);
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  for (const double from : {0.0, 0.03, 0.06, 0.2}) {
    const Model start = with(c, c.of("coulomb_friction"), {from});
    double before = fit(around, start, 0).objective;
    for (const int iterations : {1, 3, 7}) {
      const double after = fit(around, start, iterations).objective;
      EXPECT_LE(after, before * (1 + 1e-9)) << from << ", " << iterations;
      before = after;
    }
  }
}

TEST(Fit, GoneOnWithIsTheSameAsInOnePiece) {
  const SmallComparison c = rubbing(2);
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  const Model start = with(c, c.of("coulomb_friction"), {0.02});
  const FitResult once = fit(around, start, 7), twice = resume(around, fit(around, start, 2), 6);
  EXPECT_NEAR(once.model.effects[0].theta[0], twice.model.effects[0].theta[0], 1e-3);
}

/// What is left out has no part in a fit, which says about it what its model says.
TEST(Fit, PredictsWhatItLeavesOutByTheModelThatTheOthersGive) {
  const SmallComparison c = rubbing(1);
  Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  const Model start = with(c, c.of("coulomb_friction"), {0.01});
  for (std::size_t group = 0; group < c.problem->groups; ++group) {
    around.left_out = group;
    const QuickFit quick = quick_fit(around, start, 3);
    EXPECT_TRUE(quick.r == prediction_error(c.problem, c.library, quick.model)) << group;
    const FitResult whole = fit(around, start, 3);
    EXPECT_EQ(quick.model.effects[0].theta, whole.model.effects[0].theta) << group;
    EXPECT_EQ(quick.model.nuisance, whole.model.nuisance) << group;
    EXPECT_NEAR(quick.objective, whole.objective, 1e-12 * whole.objective) << group;
  }
}

TEST(Fit, AnEffectThatIsThereLowersTheHeldOutError) {
  const SmallComparison c = rubbing(3, 3);
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  const FitResult without = fit(around, nominal(c), 7), with_it = fitted(c, around, 0.04);
  const HeldoutGain gain = compare(Settings{}.decisions, heldout_energy(around, without),
                                   heldout_energy(around, with_it));
  EXPECT_TRUE(gain.beyond_chance());
  EXPECT_GT(gain.energy.total, gain.energy.lower);
  EXPECT_GT(gain.bounded.total, gain.bounded.lower);
}

TEST(Fit, AnEffectThatIsNotThereGainsNothingSure) {
  int sure = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, seed, 3);
    const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
    const HeldoutGain gain =
        compare(Settings{}.decisions, heldout_energy(around, fit(around, nominal(c), 7)),
                heldout_energy(around, fitted(c, around, 0.01)));
    sure += gain.beyond_chance();
  }
  EXPECT_LE(sure, 1);
}

/// Energies of `n` shots: `quiet` but for every `period`-th, which is `loud`.
Eigen::VectorXd energies(Eigen::Index n, double quiet, Eigen::Index period, double loud) {
  Eigen::VectorXd out = Eigen::VectorXd::Constant(n, quiet);
  for (Eigen::Index i = 0; i < n; i += period) out[i] = loud;
  return out;
}

TEST(HeldOutGain, ComparingTheOtherWayRoundTurnsTheSign) {
  const Eigen::VectorXd a = energies(60, 40.0, 7, 900.0), b = energies(60, 35.0, 11, 300.0);
  const DecisionSettings decisions;
  const HeldoutGain there = compare(decisions, a, b), back = compare(decisions, b, a);
  EXPECT_NEAR(there.energy.total, -back.energy.total, 1e-9);
  EXPECT_NEAR(there.bounded.total, -back.bounded.total, 1e-9);
  EXPECT_NEAR(there.bounded.standard_error, back.bounded.standard_error, 1e-9);
}

TEST(HeldOutGain, AFewLoudShotsDoNotHideWhatAllOthersGain) {
  // a tenth of the energy goes in every shot; in two of them stick-slip is as loud as all the rest,
  // once better and once worse
  Eigen::VectorXd before = energies(80, 50.0, 100, 50.0), after = 0.9 * before;
  for (Eigen::Index i = 0; i < before.size(); ++i)
    after[i] *= 1.0 + 0.05 * std::sin(12.9 * static_cast<double>(i));
  before[20] = 4000.0, after[20] = 7000.0;
  before[60] = 9000.0, after[60] = 5000.0;
  const HeldoutGain gain = compare(DecisionSettings{}, before, after);
  EXPECT_LT(gain.energy.lower, 0.0);
  EXPECT_GT(gain.bounded.lower, 0.0);
  EXPECT_TRUE(gain.beyond_chance());
  EXPECT_GT(gain.certainty(), 2.0);
}

TEST(HeldOutGain, LoudShotsAloneProveNothing) {
  // better once, worse once, nothing in all others
  Eigen::VectorXd before = energies(80, 50.0, 100, 50.0), after = before;
  for (Eigen::Index i = 0; i < before.size(); ++i)
    after[i] *= 1.0 + 0.02 * std::sin(12.9 * static_cast<double>(i));
  before[20] = 9000.0, after[20] = 100.0;
  before[60] = 100.0, after[60] = 4000.0;
  const HeldoutGain gain = compare(DecisionSettings{}, before, after);
  EXPECT_GT(gain.removed(), 0.0);
  EXPECT_FALSE(gain.beyond_chance());
}

TEST(HeldOutGain, OfShotsAlikeBothMeasuresSayTheSame) {
  const Eigen::VectorXd before = Eigen::VectorXd::Constant(50, 100.0), after = 0.98 * before;
  const HeldoutGain gain = compare(DecisionSettings{}, before, after);
  EXPECT_NEAR(gain.bounded.total, 0.5 * gain.removed(), 0.01 * gain.removed());
  EXPECT_NEAR(gain.whole, 50 * 99.0 * std::log(199.0 / 99.0), 1e-9 * gain.whole);
}

/// A limit that may be off has a range of a million: what is small in it is not at its end.
TEST(Fit, ALimitIsAtItsBoundOnlyThere) {
  const SmallComparison c = rubbing(1, 2, {"servo_profile"});
  const int profile = c.of("servo_profile");
  ASSERT_GE(profile, 0);
  const CandidateParameter& speed = c.library[profile].parameters[0];
  const double off = speed.high, steepest = c.library[profile].parameters[1].high;
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  const auto held = [&](double at) {
    return fit(around, with(c, profile, {at, steepest}), 0).fixed[0] != 0;
  };
  EXPECT_TRUE(held(speed.low));
  EXPECT_FALSE(held(1.01 * speed.low));
  EXPECT_FALSE(held(3.0 * speed.low));
  EXPECT_FALSE(held(0.99 * off));
  EXPECT_TRUE(held(off));
}

TEST(Fit, AModelMovesInsideItsBounds) {
  const SmallComparison c = rubbing(4);
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  const Model model = with(c, c.of("coulomb_friction"), {0.02});
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(1 + around.A.cols());
  EXPECT_EQ(moved(around, model, delta).effects[0].theta, model.effects[0].theta);
  delta.setConstant(1e6);
  const Model far = moved(around, model, delta);
  const Candidate& candidate =
      c.library.candidates[static_cast<std::size_t>(c.of("coulomb_friction"))];
  EXPECT_NEAR(far.effects[0].theta[0], candidate.parameters[0].high, 1e-9);
  for (std::size_t k = 0; k < far.nuisance.size(); ++k)
    EXPECT_NEAR(far.nuisance[k], c.library.nuisances[k].tolerance, 1e-12);
}

TEST(Fit, HeldOutEnergyIsMoreThanWhatWasFitted) {
  const SmallComparison c = rubbing(4, 3);
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  const FitResult f = fitted(c, around, 0.04);
  const double seen = around.bounded(around.starts.energy_by_shot(f.r)).sum();
  const double one_step = heldout_energy(around, f).sum(),
               refitted = refitted_energy(around, f).sum();
  EXPECT_GE(one_step, seen * (1 - 1e-6));
  EXPECT_NEAR(one_step, refitted, 0.1 * refitted);
}

TEST(Fit, BestStartIsNoWorseThanTheNull) {
  const SmallComparison c = rubbing(5);
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  const Model start = best_start(around, nominal(c), c.of("coulomb_friction"), nullptr);
  ASSERT_EQ(start.effects.size(), 1u);
  EXPECT_LT(fit(around, start, 0).objective, fit(around, nominal(c), 0).objective);
  EXPECT_NEAR(start.effects[0].theta[0], kHidden, 0.04);
}

TEST(Fit, ARobustCovarianceIsNeverSmaller) {
  const SmallComparison c = rubbing(6, 3);
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  const FitResult f = fitted(c, around, 0.04);
  const double trusting = f.covariance(0, 0), once = robust_covariance(around, f, 1.0)(0, 0),
               four_times = robust_covariance(around, f, 4.0)(0, 0);
  EXPECT_GE(once, trusting * (1 - 1e-6));
  EXPECT_GE(four_times, once);
  EXPECT_GE(four_times, 3.5 * trusting) << "all but what the tolerances of the nuisances know";
}

TEST(Bounded, IsTheEnergyWhereItIsSmallAndGrowsSlowerBeyond) {
  const SmallComparison c = rubbing(1);
  Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  const auto n = static_cast<Eigen::Index>(c.problem->shots.size());
  around.shot_scale = 4.0;
  double before = -1.0;
  for (double e = 0.0; e < 1e5; e = 2 * e + 1) {
    const Eigen::VectorXd energy = Eigen::VectorXd::Constant(n, e);
    const double value = around.bounded(energy)[0], weight = around.weights(energy)[0];
    EXPECT_LE(value, e);
    EXPECT_GT(value, before);
    EXPECT_GT(weight, 0.0);
    EXPECT_LE(weight, 1.0);
    const double step = 1e-4 * (1.0 + e);
    const Eigen::VectorXd more = Eigen::VectorXd::Constant(n, e + step);
    EXPECT_NEAR((around.bounded(more)[0] - value) / step, weight, 1e-3) << e;
    before = value;
  }
}

TEST(Bounded, AGroupThatIsLeftOutCountsNothing) {
  const SmallComparison c = rubbing(1);
  Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  around.left_out = 1;
  const Eigen::VectorXd ones =
      Eigen::VectorXd::Ones(static_cast<Eigen::Index>(c.problem->shots.size()));
  const Eigen::VectorXd w = around.weights(ones);
  for (std::size_t s = 0; s < c.problem->shots.size(); ++s)
    EXPECT_EQ(w[s] == 0.0, c.problem->shots[s].group == 1);
}

TEST(Compare, OfTheSameIsNothingAndOfTheOppositeTheOpposite) {
  const DecisionSettings decisions;
  Random random(3);
  Eigen::VectorXd a(60), b(60);
  for (double& e : a) e = 20.0 + random.normal();
  for (double& e : b) e = 19.0 + random.normal();
  EXPECT_EQ(compare(decisions, a, a).removed(), 0.0);
  EXPECT_NEAR(compare(decisions, a, b).removed(), -compare(decisions, b, a).removed(), 1e-9);
  EXPECT_TRUE(compare(decisions, a, b).beyond_chance());
  EXPECT_FALSE(compare(decisions, b, a).beyond_chance());
  EXPECT_LT(compare(decisions, a, b).energy.lower, compare(decisions, a, b).energy.total);
}

TEST(Compare, ConcentrationTellsOneLuckyShotFromAll) {
  const DecisionSettings decisions;
  const Eigen::VectorXd before = Eigen::VectorXd::Constant(60, 20.0);
  Eigen::VectorXd everywhere = Eigen::VectorXd::Constant(60, 19.0), lucky = before;
  lucky[7] = 0.0;
  EXPECT_NEAR(compare(decisions, before, everywhere).concentration, 3.0 / 60.0, 0.01);
  EXPECT_NEAR(compare(decisions, before, lucky).concentration, 1.0, 0.01);
}

TEST(Overdispersion, OfNoiseIsOneAndGrowsWithTheSquare) {
  const SmallComparison c = rubbing(1, 3);
  Random random(8);
  Eigen::VectorXd r(static_cast<Eigen::Index>(c.problem->size));
  for (double& e : r) e = random.normal();
  const double one = overdispersion(*c.problem, r)[0];
  EXPECT_NEAR(one, 1.2, 0.4);
  EXPECT_NEAR(overdispersion(*c.problem, 3.0 * r)[0] / one, 9.0, 1e-6);
}

TEST(RoughFit, GivenItsDerivativesIsTheFit) {
  const SmallComparison c = rubbing(5);
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  const Model start = with(c, c.of("coulomb_friction"), {0.02});
  for (const int iterations : {0, 1, 3, 9}) {
    const FitResult whole = fit(around, start, iterations);
    FitResult rough = rough_fit(around, start, iterations);
    EXPECT_EQ(rough.covariance.size(), 0);
    EXPECT_EQ(rough.r, whole.r);
    EXPECT_EQ(rough.objective, whole.objective);
    EXPECT_EQ(rough.fixed, whole.fixed);
    EXPECT_EQ(rough.converged, whole.converged);
    rough = resume(around, std::move(rough), 0);
    EXPECT_EQ(rough.J, whole.J);
    EXPECT_EQ(rough.covariance, whole.covariance);
    EXPECT_EQ(rough.model.effects[0].theta, whole.model.effects[0].theta);
    EXPECT_EQ(rough.converged, whole.converged);
  }
}

TEST(QuickFit, IsTheFitWithoutDerivatives) {
  const SmallComparison c =
      compared(pendulum(kNoisyServo), {hidden("coulomb_friction", "a", {{"coulomb", 0.08}})},
               {"coulomb_friction"}, 17);
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  Model start = nominal(c);
  start.effects.push_back({c.of("coulomb_friction"), {0.02}});
  for (const int iterations : {0, 1, 3, 9}) {
    const FitResult whole = fit(around, start, iterations);
    const QuickFit quick = quick_fit(around, start, iterations);
    EXPECT_DOUBLE_EQ(quick.model.effects[0].theta[0], whole.model.effects[0].theta[0]);
    EXPECT_EQ(quick.model.nuisance, whole.model.nuisance);
    EXPECT_EQ(quick.r, whole.r);
    EXPECT_NEAR(quick.objective, whole.objective, 1e-6 * whole.objective);
  }
}

}  // namespace
}  // namespace sanso::diagnose
