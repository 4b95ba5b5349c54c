// What a fit is worth on groups that it has not seen: one linear step and a real refit agree where
// the model is linear, neither sees the group itself, and nothing leaves its bounds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/fit/fit.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr double kHidden = 0.12;  // N m s/rad

/// A pendulum with more viscous friction than its model says: smooth in its parameter. Nuisances
/// can be taken out, so that no bound binds.
struct Damped : SmallComparison {
  explicit Damped(std::uint64_t seed, bool nuisances = false, int count = 3)
      : SmallComparison(compared(pendulum(kNoisyServo),
                                 {hidden("viscous_friction", "a", {{"viscous", kHidden}})},
                                 {"viscous_friction"}, seed, count)) {
    if (!nuisances) library.nuisances.clear();
  }
  Model start(double viscous) const { return with(*this, of("viscous_friction"), {viscous}); }
  Surroundings around() const { return make_surroundings(problem, library, start(kHidden)); }
  double typical() const { return library[of("viscous_friction")].parameters[0].typical; }
};

double sum_of(const Surroundings& around, const Eigen::VectorXd& by_shot, std::size_t group) {
  double sum = 0.0;
  for (std::size_t s = 0; s < around.problem->shots.size(); ++s)
    sum += around.problem->shots[s].group == group ? by_shot[static_cast<Eigen::Index>(s)] : 0.0;
  return sum;
}

/// The same recordings, those of one group with something on their readings.
Damped with_bent_readings(Damped c, std::size_t group) {
  Comparison changed = *c.problem;
  for (const Shot& shot : c.problem->shots) {
    if (shot.group != group) continue;
    std::vector<double>& q = changed.sources[shot.source].drive.joints[0].q;
    for (std::size_t k = shot.window.first + 1; k <= shot.window.last; ++k)
      q[k] += 2e-3 * std::sin(0.3 * static_cast<double>(k));
  }
  c.problem.comparison = std::make_shared<const Comparison>(std::move(changed));
  return c;
}

TEST(HeldOut, TheLinearStepIsTheRefitWhereNoBoundBinds) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Damped c(seed);
    const Surroundings around = c.around();
    const FitResult f = fit(around, c.start(0.1), 12);
    ASSERT_FALSE(f.fixed[0]);
    const Eigen::VectorXd linear = heldout_energy(around, f), refitted = refitted_energy(around, f),
                          seen = around.bounded(around.starts.energy_by_shot(f.r));
    for (std::size_t g = 0; g < c.problem->groups; ++g) {
      const double held = sum_of(around, refitted, g);
      EXPECT_NEAR(sum_of(around, linear, g), held, 2e-3 * held) << "group " << g;
      // the optimum of all is not that of the others: a group is predicted worse than it was fitted
      EXPECT_GE(held, sum_of(around, seen, g) * (1 - 1e-6)) << "group " << g;
    }
    EXPECT_GT(linear.sum(), seen.sum());
  }
}

TEST(HeldOut, TheRefitIsThatOfTheOthersAlone) {
  // by hand: fit on the other groups only, then predict the one left out
  const Damped c(4);
  const Surroundings around = c.around();
  const FitResult f = fit(around, c.start(0.1), 12);
  const Eigen::VectorXd refitted = refitted_energy(around, f);
  for (std::size_t g = 0; g < c.problem->groups; ++g) {
    std::vector<std::size_t> others;
    for (std::size_t s = 0; s < c.problem->shots.size(); ++s)
      if (c.problem->shots[s].group != g) others.push_back(s);
    const Problem rest = with_shots(c.problem, others);
    const FitResult alone =
        fit(make_surroundings(rest, c.library, c.start(kHidden)), c.start(0.1), 12);
    const Eigen::VectorXd energy =
        around.starts.energy_by_shot(prediction_error(c.problem, c.library, alone.model));
    const double held = sum_of(around, energy, g);
    EXPECT_NEAR(sum_of(around, refitted, g), held, 1e-3 * held) << "group " << g;
  }
}

TEST(HeldOut, AGroupIsNotSeenByTheFitWithoutIt) {
  const Damped c(5);
  constexpr std::size_t kGroup = 1;
  const Damped bent = with_bent_readings(c, kGroup);
  const auto without = [&](const Damped& d) {
    Surroundings around = d.around();
    around.left_out = kGroup;
    return fit(around, d.start(0.1), 12).model.effects[0].theta[0];
  };
  const auto all = [](const Damped& d) {
    return fit(d.around(), d.start(0.1), 12).model.effects[0].theta[0];
  };
  EXPECT_EQ(without(c), without(bent));
  EXPECT_GT(std::abs(all(c) - all(bent)), 1e-4) << "the readings did not change anything";
}

TEST(HeldOut, WhatAGroupReadsIsOnlyPredictedNeverFitted) {
  // where a group's readings are bent, the full fit follows them; the step without it must not, so
  // what is told of the group is as bad as a prediction by the others
  const Damped bent = with_bent_readings(Damped(6), 1);
  const Surroundings around = bent.around();
  const FitResult f = fit(around, bent.start(0.1), 12);
  Surroundings rest = around;
  rest.left_out = 1;
  const FitResult others = fit(rest, bent.start(0.1), 12);
  const double predicted = sum_of(around, around.starts.energy_by_shot(others.r), 1);
  const double told = sum_of(around, heldout_energy(around, f), 1);
  EXPECT_NEAR(told, predicted, 5e-3 * predicted);
  EXPECT_GT(told, sum_of(around, around.starts.energy_by_shot(f.r), 1));
}

TEST(HeldOut, WhereNoStepServesTheOthersTheGroupIsStillNotSeen) {
  // a derivative of the wrong sign, as of friction that sticks a moment later: every step from the
  // full fit makes the others worse
  const Damped bent = with_bent_readings(Damped(6), 1);
  const Surroundings around = bent.around();
  FitResult f = fit(around, bent.start(0.1), 12);
  const double seen = sum_of(around, around.bounded(around.starts.energy_by_shot(f.r)), 1);
  const double told_before = sum_of(around, heldout_energy(around, f), 1);
  f.J.col(0) *= -1.0;
  const double told = sum_of(around, heldout_energy(around, f), 1);
  ASSERT_GT(told_before, seen + 1.0) << "the group pulled at the fit";
  EXPECT_NEAR(told, told_before, 0.2 * (told_before - seen));
}

TEST(Displacement, IsWhatMovedMoves) {
  const Damped c(13, true, 2);
  const Surroundings around = c.around();
  const Model from = c.start(0.07);
  Eigen::VectorXd delta =
      Eigen::VectorXd::Constant(1 + static_cast<Eigen::Index>(c.library.nuisances.size()), 0.1);
  delta[0] = -0.2;
  EXPECT_LT((displacement(around, from, moved(around, from, delta)) - delta).norm(), 1e-12);
}

TEST(HeldOut, AConditionLeftOutIsAGroupWhereTheyAreTheSame) {
  Damped c(8);
  Comparison changed = *c.problem;
  for (Shot& shot : changed.shots) shot.condition = shot.group;
  changed.conditions = changed.groups;
  c.problem.comparison = std::make_shared<const Comparison>(std::move(changed));
  const Surroundings around = c.around();
  const FitResult f = fit(around, c.start(0.1), 12);
  EXPECT_EQ(heldout_energy(around, f, true), heldout_energy(around, f, false));
}

TEST(Room, IsWhatAModelCanReallyMove) {
  const Damped c(9, true, 2);
  const Surroundings around = c.around();
  Model model = c.start(0.07);
  for (std::size_t k = 0; k < model.nuisance.size(); ++k)
    model.nuisance[k] = (k % 2 == 0 ? 0.4 : -1.0) * c.library.nuisances[k].tolerance;
  const Eigen::MatrixXd room = room_to_move(around, model);
  ASSERT_EQ(room.rows(), 1 + static_cast<Eigen::Index>(c.library.nuisances.size()));
  for (const int side : {0, 1}) {
    const double sign = side == 0 ? -1.0 : 1.0;
    const Model edge = moved(around, model, room.col(side));
    // further than the room, the model stays at the same edge
    const Model beyond =
        moved(around, model, room.col(side) + sign * Eigen::VectorXd::Ones(room.rows()));
    EXPECT_NEAR(edge.effects[0].theta[0], beyond.effects[0].theta[0], 1e-12);
    const CandidateParameter& p = c.library[c.of("viscous_friction")].parameters[0];
    EXPECT_NEAR(edge.effects[0].theta[0], side == 0 ? p.low : p.high, 1e-9);
    for (std::size_t k = 0; k < edge.nuisance.size(); ++k)
      EXPECT_NEAR(edge.nuisance[k], sign * c.library.nuisances[k].tolerance, 1e-12) << k;
  }
  EXPECT_LE(room.col(0).maxCoeff(), 0.0);
  EXPECT_GE(room.col(1).minCoeff(), 0.0);
  EXPECT_NEAR(room(0, 1) - room(0, 0),
              (c.library[c.of("viscous_friction")].parameters[0].high -
               c.library[c.of("viscous_friction")].parameters[0].low) /
                  c.typical(),
              1e-9);
}

TEST(RobustCovariance, HoldsTheSpreadOfAGroupThatDisagrees) {
  const Damped c(10);
  const Damped bent = with_bent_readings(c, 2);
  const auto variances = [](const Damped& d) {
    const Surroundings around = d.around();
    const FitResult f = fit(around, d.start(0.1), 12);
    return std::pair{f.covariance(0, 0), robust_covariance(around, f, 1.0)(0, 0)};
  };
  const auto [plain, robust] = variances(c);
  const auto [plain_bent, robust_bent] = variances(bent);
  EXPECT_GE(robust, plain * (1 - 1e-9));
  // the same data say as much as before to who trusts the noise, and less to who asks the groups
  EXPECT_NEAR(plain_bent, plain, 0.05 * plain);
  EXPECT_GT(robust_bent, 2.0 * robust);
}

TEST(RobustCovariance, StaysACovariance) {
  const Damped c(11, true);
  const Surroundings around = c.around();
  const FitResult f = fit(around, c.start(0.1), 7);
  const Eigen::MatrixXd C = robust_covariance(around, f, 2.0);
  EXPECT_LT((C - C.transpose()).cwiseAbs().maxCoeff(), 1e-9 * C.cwiseAbs().maxCoeff());
  for (Eigen::Index i = 0; i < C.rows(); ++i) {
    EXPECT_GE(C(i, i), f.covariance(i, i) * (1 - 1e-9)) << i;
    for (Eigen::Index j = 0; j < i; ++j)
      EXPECT_LE(C(i, j) * C(i, j), C(i, i) * C(j, j) * (1 + 1e-9)) << i << ", " << j;
  }
}

TEST(Measures, AreOrderedAndDoNotCareForTheOrderOfWholeGroups) {
  const DecisionSettings decisions;
  Random random(12);
  Eigen::VectorXd before(60), after(60);
  for (Eigen::Index i = 0; i < before.size(); ++i) {
    before[i] = 50.0 * std::exp(random.normal());
    after[i] = before[i] * (0.5 + 0.4 * random.uniform());
  }
  const HeldoutGain gain = compare(decisions, before, after);
  // log(1 + x) <= x: bounded never promises more than the sum of squares
  EXPECT_LT(gain.bounded.total, gain.energy.total);
  EXPECT_LT(gain.bounded.lower, gain.bounded.total);
  EXPECT_LT(gain.energy.lower, gain.energy.total);
  // nothing removes more than everything
  const HeldoutGain all = compare(decisions, before, Eigen::VectorXd::Zero(60));
  EXPECT_NEAR(all.removed(), before.sum(), 1e-9 * before.sum());
  EXPECT_NEAR(all.bounded.total, all.whole, 1e-9 * all.whole);
  // units of energy: ten times the energies, ten times the gain
  const HeldoutGain tenfold = compare(decisions, 10.0 * before, 10.0 * after);
  EXPECT_NEAR(tenfold.bounded.total, 10.0 * gain.bounded.total, 1e-6 * tenfold.bounded.total);
  EXPECT_NEAR(tenfold.energy.lower, 10.0 * gain.energy.lower, 1e-6 * tenfold.energy.total);
}

TEST(Measures, LessLeftIsMoreGained) {
  const DecisionSettings decisions;
  const Eigen::VectorXd before = Eigen::VectorXd::LinSpaced(40, 20.0, 90.0);
  double energy = -1.0, bounded = -1.0;
  for (const double left : {1.0, 0.8, 0.5, 0.1}) {
    const HeldoutGain gain = compare(decisions, before, left * before);
    EXPECT_GT(gain.energy.total, energy) << left;
    EXPECT_GT(gain.bounded.total, bounded) << left;
    energy = gain.energy.total, bounded = gain.bounded.total;
  }
}

TEST(Measures, OccurrencesAreJudgedOneByOne) {
  // three occurrences of two shots gain, all others nothing: the bound over occurrences is the
  // total, that over all shots alike asks whether they were drawn at all
  Comparison of_one_recording;
  of_one_recording.shots.resize(60);
  const Eigen::VectorXd before = Eigen::VectorXd::Constant(60, 40.0);
  Eigen::VectorXd after = before;
  std::vector<std::optional<std::size_t>> occurrence(60);
  for (const Eigen::Index i : {10, 30, 50}) {
    after[i] = 10.0, after[i + 1] = 20.0;
    occurrence[static_cast<std::size_t>(i)] = occurrence[static_cast<std::size_t>(i + 1)] =
        static_cast<std::size_t>(i);
  }
  const HeldoutGain alike = compare(of_one_recording, before, after),
                    apart = compare(of_one_recording, before, after, occurrence);
  EXPECT_NEAR(apart.energy.total, alike.energy.total, 1e-9);
  EXPECT_NEAR(apart.energy.lower, apart.energy.total, 1e-6) << "each occurrence gains the same";
  EXPECT_LT(alike.energy.lower, 0.8 * alike.energy.total);
  EXPECT_LT(apart.energy.standard_error, alike.energy.standard_error);
}

/// Four recordings of 37 shots; in the second the cause shows, in the others it does next to
/// nothing, and as often harm as good.
struct ShowsInOneRecording {
  Comparison comparison;
  Eigen::VectorXd before, after;
  explicit ShowsInOneRecording(double gained) : before(148), after(148) {
    Random random(21);
    comparison.shots.resize(148);
    for (Eigen::Index s = 0; s < 148; ++s) {
      Shot& shot = comparison.shots[static_cast<std::size_t>(s)];
      shot.source = static_cast<std::size_t>(s) / 37;
      const bool shows = shot.source == 1;
      after[s] = (shows ? 900.0 : 100.0) * (1.0 + 0.3 * random.uniform());
      before[s] = after[s] + (shows ? gained * (1.0 + 0.3 * random.uniform()) : -10.0) +
                  10.0 * random.normal();
    }
  }
};

TEST(Measures, WhatShowsInOneRecordingOfSeveralIsNoChance) {
  // a rotor in the fast recording of four: taken for one series of shots, three blocks of it may
  // miss that recording, and nothing would be certain
  const ShowsInOneRecording c(3500.0);
  const HeldoutGain apart = compare(c.comparison, c.before, c.after),
                    as_one = compare(c.comparison.settings.decisions, c.before, c.after);
  EXPECT_NEAR(apart.energy.total, as_one.energy.total, 1e-6 * as_one.energy.total);
  EXPECT_GT(apart.energy.lower, 0.8 * apart.energy.total);
  EXPECT_GT(apart.bounded.lower, 0.5 * apart.bounded.total);
  // who is told from whom: there recordings have to agree
  EXPECT_NEAR(apart.energy.standard_error, as_one.energy.standard_error,
              1e-9 * as_one.energy.standard_error);
  EXPECT_LT(as_one.energy.lower, 0.2 * as_one.energy.total);
}

TEST(Measures, NothingInEveryRecordingStaysChance) {
  const ShowsInOneRecording c(-10.0);
  EXPECT_FALSE(compare(c.comparison, c.before, c.after).beyond_chance());
  EXPECT_TRUE(compare(c.comparison, c.after, c.before).beyond_chance());
}

/// One recording of 60 shots that a cause moves alike, and ten in a row, a sweep through a
/// resonance, far more. `agree`: the share of the other shots that it serves.
HeldoutGain in_one_stretch(double agree) {
  Comparison comparison;
  comparison.shots.resize(60);
  Eigen::VectorXd before(60), after(60);
  Random random(23);
  for (Eigen::Index s = 0; s < 60; ++s) {
    const bool sweeps = s >= 20 && s < 30;
    after[s] = 90.0 + 5.0 * random.normal();
    const double helps = random.uniform() < agree ? 1.0 : -1.0;
    before[s] = after[s] + (sweeps ? 150.0 * static_cast<double>(s - 19)
                                   : helps * (5.0 + 10.0 * random.uniform()));
  }
  return compare(comparison, before, after);
}

TEST(Measures, AGainInOneStretchIsProvedByTheShotsAroundIt) {
  // a sum has no bound without the stretch that holds it; that nearly every shot agrees has one
  const HeldoutGain true_cause = in_one_stretch(0.95);
  EXPECT_LT(true_cause.energy.lower, 0.0);
  EXPECT_GT(true_cause.ranks.lower, 0.2);
  EXPECT_TRUE(true_cause.beyond_chance());
  // what serves the stretch and hurts elsewhere as often as it helps is proved by nothing
  EXPECT_FALSE(in_one_stretch(0.5).beyond_chance());
}

TEST(Measures, RanksCountWhatIsNeitherHereNorThereAsNothing) {
  const DecisionSettings decisions;
  const Eigen::VectorXd before = Eigen::VectorXd::LinSpaced(40, 20.0, 90.0);
  EXPECT_EQ(compare(decisions, before, before).ranks.total, 0.0);
  EXPECT_NEAR(compare(decisions, before, 0.5 * before).ranks.total, 1.0, 1e-12);
  EXPECT_NEAR(compare(decisions, 0.5 * before, before).ranks.total, -1.0, 1e-12);
  // whatever the sizes
  Eigen::VectorXd after = before.array() - 1.0;
  after[39] = -1e6;
  EXPECT_NEAR(compare(decisions, before, after).ranks.total, 1.0, 1e-12);
}

TEST(Measures, RecordingsOfAShotEachScatterTogether) {
  // alone they could not tell what is chance, and every sum would be certain
  Comparison comparison;
  comparison.shots.resize(40);
  Eigen::VectorXd before(40), after = Eigen::VectorXd::Constant(40, 100.0);
  Random random(22);
  for (Eigen::Index s = 0; s < 40; ++s) {
    comparison.shots[static_cast<std::size_t>(s)].source = static_cast<std::size_t>(s);
    before[s] = 101.0 + 20.0 * random.normal();
  }
  const HeldoutGain gain = compare(comparison, before, after),
                    as_one = compare(comparison.settings.decisions, before, after);
  EXPECT_FALSE(gain.beyond_chance());
  EXPECT_DOUBLE_EQ(gain.energy.lower, as_one.energy.lower);
}

}  // namespace
}  // namespace sanso::diagnose
