// The fit: derivatives, recovery of what was hidden with honest intervals, held-out energies.
#include "tools/diagnose/fit/fit.h"

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
  const double typical = c.library.candidates[static_cast<std::size_t>(c.of("viscous_friction"))]
                             .parameters[0]
                             .typical;
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
    const auto col = around.A.col(static_cast<Eigen::Index>(k));
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

TEST(Fit, AnEffectThatIsThereLowersTheHeldOutError) {
  const SmallComparison c = rubbing(3, 3);
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  const FitResult without = fit(around, nominal(c), 7), with_it = fitted(c, around, 0.04);
  const HeldoutGain gain = compare(Settings{}.decisions, heldout_energy(around, without),
                                   heldout_energy(around, with_it));
  EXPECT_GT(gain.lower, 0.0);
  EXPECT_GT(gain.total, gain.lower);
}

TEST(Fit, AnEffectThatIsNotThereGainsNothingSure) {
  int sure = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, seed, 3);
    const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
    const HeldoutGain gain =
        compare(Settings{}.decisions, heldout_energy(around, fit(around, nominal(c), 7)),
                heldout_energy(around, fitted(c, around, 0.01)));
    sure += gain.lower > 0.0;
  }
  EXPECT_LE(sure, 1);
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
  const auto n = static_cast<Eigen::Index>(c.problem.shots.size());
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
      Eigen::VectorXd::Ones(static_cast<Eigen::Index>(c.problem.shots.size()));
  const Eigen::VectorXd w = around.weights(ones);
  for (std::size_t s = 0; s < c.problem.shots.size(); ++s)
    EXPECT_EQ(w[static_cast<Eigen::Index>(s)] == 0.0, c.problem.shots[s].group == 1);
}

TEST(Compare, OfTheSameIsNothingAndOfTheOppositeTheOpposite) {
  const DecisionSettings decisions;
  Random random(3);
  Eigen::VectorXd a(60), b(60);
  for (double& e : a) e = 20.0 + random.normal();
  for (double& e : b) e = 19.0 + random.normal();
  EXPECT_EQ(compare(decisions, a, a).total, 0.0);
  EXPECT_NEAR(compare(decisions, a, b).total, -compare(decisions, b, a).total, 1e-9);
  EXPECT_GT(compare(decisions, a, b).lower, 0.0);
  EXPECT_LT(compare(decisions, b, a).lower, 0.0);
  EXPECT_LT(compare(decisions, a, b).lower, compare(decisions, a, b).total);
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
  Eigen::VectorXd r(static_cast<Eigen::Index>(c.problem.size));
  for (double& e : r) e = random.normal();
  const double one = overdispersion(c.problem, r)[0];
  EXPECT_NEAR(one, 1.2, 0.4);
  EXPECT_NEAR(overdispersion(c.problem, 3.0 * r)[0] / one, 9.0, 1e-6);
}

}  // namespace
}  // namespace sanso::diagnose
