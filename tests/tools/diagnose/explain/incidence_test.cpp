// What an explanation promises, and whether it happened: slopes, the jackknife's intervals, words.
#include "tools/diagnose/explain/incidence.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/noisy_world.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr double kHidden = 0.08;  // N m

/// A pendulum in a world with `rubbing` of dry friction that its model does not know.
struct Bench : SmallComparison {
  explicit Bench(double rubbing)
      : SmallComparison(compared(
            pendulum(kNoisyServo),
            rubbing > 0.0 ? std::vector{hidden("coulomb_friction", "a", {{"coulomb", rubbing}})}
                          : std::vector<EffectEntry>{},
            {"coulomb_friction"}, 21, 3)),
        around(make_surroundings(problem, library, nominal(*this))),
        regimes(find_regimes(*problem)) {}

  /// The model with this friction, as it is: nothing fitted.
  FitResult at(double coulomb) const {
    const Model m = coulomb > 0.0 ? with(*this, of("coulomb_friction"), {coulomb}) : nominal(*this);
    return fit(around, m, 0);
  }
  std::vector<IncidenceRow> promised(double coulomb) const {
    return incidence(around, regimes, at(0.0), at(coulomb));
  }
  /// Fits with these errors, whose difference is the promise.
  std::vector<IncidenceRow> of_errors(const Eigen::VectorXd& r, const Eigen::VectorXd& d) const {
    FitResult without = at(0.0), with = without;
    without.r = r;
    with.r = r - d;
    return incidence(around, regimes, without, with);
  }
  Surroundings around;
  Regimes regimes;
};

const IncidenceRow& row(const std::vector<IncidenceRow>& rows, Signal signal,
                        const std::string& regime = "") {
  for (const IncidenceRow& r : rows)
    if (r.residual.signal == signal && r.residual.regime == regime) return r;
  throw std::out_of_range("no such row");
}

/// Errors that look like what friction does, `level(shot)` times as large in every shot.
template <class Level>
Eigen::VectorXd shaped(const Comparison& comparison, const Level& level) {
  Eigen::VectorXd out(static_cast<Eigen::Index>(comparison.size));
  for (std::size_t s = 0; s < comparison.shots.size(); ++s) {
    auto piece = rows_of(out, comparison.shots[s], 0);
    for (Eigen::Index k = 0; k < piece.size(); ++k)
      piece[k] = level(s) * std::sin(0.9 * static_cast<double>(k) + 0.4 * static_cast<double>(s));
  }
  return out;
}

TEST(Incidence, TheTrueEffectKeepsItsPromiseInEveryResidual) {
  const Bench b(kHidden);
  const std::vector<IncidenceRow> rows = b.promised(kHidden);
  ASSERT_GE(rows.size(), 2U) << "positions, and at least one regime";
  for (const IncidenceRow& r : rows) {
    EXPECT_NEAR(r.slope, 1.0, 0.1) << to_string(r.residual);
    EXPECT_LE(r.low, 1.05) << to_string(r.residual);
    EXPECT_GE(r.high, 0.95) << to_string(r.residual);
  }
  EXPECT_EQ(refuted_by(rows, DecisionSettings{}), "");
}

TEST(Incidence, WhatDidNotHappenHasNoSlopeAndIsRefuted) {
  const Bench b(0.0);
  const std::vector<IncidenceRow> rows = b.promised(kHidden);
  ASSERT_FALSE(rows.empty());
  for (const IncidenceRow& r : rows) EXPECT_NEAR(r.slope, 0.0, 0.05) << to_string(r.residual);
  EXPECT_NE(refuted_by(rows, DecisionSettings{}).find("% of the promised change happened"),
            std::string::npos);
}

TEST(Incidence, ASmallerPromiseHappenedSeveralTimesOver) {
  const Bench b(kHidden);
  double before = INFINITY;
  for (const double share : {0.25, 0.5, 1.0, 2.0}) {
    const double slope = row(b.promised(share * kHidden), Signal::q).slope;
    EXPECT_LT(slope, before) << share;
    EXPECT_NEAR(slope * share, 1.0, 0.25) << share;
    before = slope;
  }
  EXPECT_NE(refuted_by(b.promised(0.25 * kHidden), DecisionSettings{}).find("times the promised"),
            std::string::npos);
}

TEST(Incidence, TheIntervalIsThatOfSlopesWithoutOneShot) {
  const Bench b(0.0);
  const Comparison& comparison = *b.problem;
  const Eigen::VectorXd promise =
      shaped(comparison, [](std::size_t s) { return 1.0 + static_cast<double>(s % 5); });
  const Eigen::VectorXd there = shaped(
      comparison, [](std::size_t s) { return 2.0 * std::cos(static_cast<double>(s)) + 1.5; });
  const IncidenceRow told = row(b.of_errors(there, promise), Signal::q);
  const Eigen::VectorXd r = b.around.starts.project(there), d = b.around.starts.project(promise);
  EXPECT_NEAR(told.predicted, d.norm(), 1e-9 * d.norm());
  EXPECT_NEAR(told.slope, d.dot(r) / d.squaredNorm(), 1e-9);
  double square = 0.0;
  for (const Shot& shot : comparison.shots) {
    const auto rs = rows_of(r, shot, 0), ds = rows_of(d, shot, 0);
    const double without = (d.dot(r) - ds.dot(rs)) / (d.squaredNorm() - ds.squaredNorm());
    square += (told.slope - without) * (told.slope - without);
  }
  EXPECT_NEAR(told.high - told.slope, 1.96 * std::sqrt(square), 1e-9);
  EXPECT_NEAR(told.slope - told.low, 1.96 * std::sqrt(square), 1e-9);
}

TEST(RefutedBy, OneOfManyPromisesMayMissByChanceAndNotByFar) {
  const auto of = [](double slope, double half) {
    IncidenceRow row;
    row.slope = slope, row.low = slope - half, row.high = slope + half;
    return row;
  };
  const IncidenceRow barely = of(0.3, 0.15), never = of(0.0, 0.1), kept = of(1.0, 0.1);
  EXPECT_EQ(refuted_by({}, DecisionSettings{}), "");
  EXPECT_NE(refuted_by({barely}, DecisionSettings{}), "");
  std::vector<IncidenceRow> many(19, kept);
  EXPECT_EQ(refuted_by(many, DecisionSettings{}), "");
  many.push_back(barely);
  EXPECT_EQ(refuted_by(many, DecisionSettings{}), "")
      << "one of twenty true ones lies outside its 95 %";
  many.push_back(never);
  EXPECT_NE(refuted_by(many, DecisionSettings{}), "");
  std::vector<IncidenceRow> several(19, kept);
  several.push_back(of(3.0, 0.3));
  EXPECT_NE(refuted_by(several, DecisionSettings{}), "");
}

TEST(Incidence, AShotThatHoldsThePromiseIsNotCertainOfIt) {
  // one shot promises nearly everything; all others contradict it, or it contradicts all others
  const Bench b(0.0);
  constexpr std::size_t kLoud = 7;
  const auto loud = [](std::size_t s) { return s == kLoud ? 60.0 : 1.0; };
  const Eigen::VectorXd promise = shaped(*b.problem, loud);
  const Eigen::VectorXd there_alone =
      shaped(*b.problem, [](std::size_t s) { return s == kLoud ? 60.0 : 0.0; });
  const IncidenceRow alone = row(b.of_errors(there_alone, promise), Signal::q);
  EXPECT_GT(alone.slope, 0.95);
  EXPECT_LT(alone.low, 0.0) << "without that shot nothing happened";
  const std::vector<IncidenceRow> others = b.of_errors(promise - there_alone, promise);
  EXPECT_LT(row(others, Signal::q).slope, 0.05);
  EXPECT_GT(row(others, Signal::q).high, 1.0) << "without that shot all of it happened";
  // the same contradiction spread over many shots is certain
  const auto even = [](std::size_t) { return 8.0; };
  const Eigen::VectorXd everywhere = shaped(*b.problem, even);
  const IncidenceRow spread =
      row(b.of_errors(shaped(*b.problem, [](std::size_t s) { return s % 8 == 0 ? 8.0 : 0.0; }),
                      everywhere),
          Signal::q);
  EXPECT_LT(spread.high, 0.5);
}

TEST(Incidence, APromiseBelowTheNoiseIsNotTold) {
  const Bench b(0.0);
  const Eigen::VectorXd there = shaped(*b.problem, [](std::size_t) { return 1.0; });
  const Eigen::VectorXd& promise = there;
  const double size = b.around.starts.project(promise).norm();
  EXPECT_TRUE(b.of_errors(there, 4.9 / size * promise).empty());
  EXPECT_FALSE(b.of_errors(there, 5.1 / size * promise).empty());
}

TEST(Incidence, RegimesAreJudgedApart) {
  // a promise kept everywhere but where the joint turns round: its own row says so
  const Bench b(0.0);
  const Eigen::VectorXd promise = shaped(*b.problem, [](std::size_t) { return 10.0; });
  const auto reversal = static_cast<std::size_t>(
      std::find(b.regimes.names.begin(), b.regimes.names.end(), "reversal") -
      b.regimes.names.begin());
  ASSERT_LT(reversal, b.regimes.names.size());
  Eigen::VectorXd there = promise;
  for (const Shot& shot : b.problem->shots) {
    auto piece = rows_of(there, shot, 0);
    for (std::size_t k = 0; k < shot.rows; ++k)
      if (b.regimes.in(shot.source, 0, reversal, recorded_row(shot, k)))
        piece[static_cast<Eigen::Index>(k)] = 0.0;
  }
  const std::vector<IncidenceRow> rows = b.of_errors(there, promise);
  EXPECT_LT(row(rows, Signal::q, "reversal").slope, 0.3);
  EXPECT_GT(row(rows, Signal::q).slope, 0.7);
  EXPECT_EQ(refuted_by(rows, DecisionSettings{}).rfind("position, reversal: ", 0), 0U)
      << refuted_by(rows, DecisionSettings{});
}

TEST(Incidence, WordsSayWhichResidualAndHowMuch) {
  const IncidenceRow kept{{Signal::q, ""}, 20.0, 1.0, 0.9, 1.1},
      missing{{Signal::q, "reversal"}, 20.0, 0.1, 0.0, 0.3},
      often{{Signal::pwm, ""}, 20.0, 3.0, 2.5, 3.5};
  EXPECT_EQ(refuted_by({}, DecisionSettings{}), "");
  EXPECT_EQ(refuted_by({kept}, DecisionSettings{}), "");
  EXPECT_EQ(refuted_by({kept, missing, often}, DecisionSettings{}),
            "position, reversal: 10 % of the promised change happened");
  EXPECT_EQ(refuted_by({kept, often, missing}, DecisionSettings{}),
            "duty: 3.0 times the promised change happened");
  // an interval that touches the limit refutes nothing
  EXPECT_EQ(refuted_by({{{Signal::q, ""}, 20.0, 0.3, 0.1, 0.5}}, DecisionSettings{}), "");
  EXPECT_EQ(refuted_by({{{Signal::q, ""}, 20.0, 2.5, 2.0, 3.0}}, DecisionSettings{}), "");
  EXPECT_NE(refuted_by({{{Signal::tau, ""}, 20.0, -1.0, -1.2, -0.8}}, DecisionSettings{}), "");
}

TEST(Incidence, EffortsAreJudgedAtTheMeasuredMotion) {
  const ModelFolder model = pendulum(kNoisyServo);
  const ModelFolder world = hiding(model, {hidden("servo_p_gain", "a", {{"gain", 0.6}})});
  const Drive drive =
      make_test_drive(world, 6.0, 0.01, [](int joint, double t) { return wave(0, joint, t); });
  const SmallComparison c(model, {record(world, drive, {.duty = true})},
                          {{"q:a", 2e-4, 0.0, {}}, {"pwm:a", 2e-3, 0.0, {}}}, {"servo_p_gain"});
  const Surroundings around = make_surroundings(c.problem, c.library, nominal(c));
  const Regimes regimes = find_regimes(*c.problem);
  FitResult without = fit(around, nominal(c), 0),
            with_it = fit(around, with(c, c.of("servo_p_gain"), {0.6}), 0);
  const IncidenceRow duty = row(incidence(around, regimes, without, with_it), Signal::pwm);
  EXPECT_NEAR(duty.slope, 1.0, 0.1);
  // whatever the simulated duty did
  for (std::size_t channel = 0; channel < c.problem->channels.size(); ++channel) {
    if (c.problem->channels[channel].signal != Signal::pwm) continue;
    for (const Shot& shot : c.problem->shots) rows_of(with_it.r, shot, channel) *= -3.0;
  }
  // and however the calibrations were fitted anew without the effect
  for (std::size_t k = 0; k < without.model.nuisance.size(); ++k)
    without.model.nuisance[k] = c.library.nuisances[k].tolerance;
  const IncidenceRow again = row(incidence(around, regimes, without, with_it), Signal::pwm);
  EXPECT_EQ(again.slope, duty.slope);
  EXPECT_EQ(again.predicted, duty.predicted);
  EXPECT_EQ(again.low, duty.low);
}

}  // namespace
}  // namespace sanso::diagnose
