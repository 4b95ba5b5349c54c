// Laws of the regression, the choice and the judgement, on rows whose truth is written by hand: a
// motion by formula, and an effort that is the nominal one, known terms and white noise.
#include "tools/diagnose/torque/judge.h"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "tests/tools/diagnose/torque/explained_effort.h"

namespace sanso::diagnose {
namespace {

using namespace test;

std::size_t index_of(const EffortDesign& design, const std::string& words) {
  for (std::size_t t = 0; t < design.terms().size(); ++t) {
    if (!design.terms()[t].nuisance && in_words(design.terms()[t]) == words) return t;
  }
  throw std::logic_error("no term " + words);
}

// ---- the regression

TEST(EffortFit, IsTheLeastSquaresOfAllCountedRows) {
  // nothing at its bound: there the best is another
  const EffortRows rows = two_link_rows([](const MotionSample& m, int j, double part) {
    return j == 1 ? 0.3 * m.q[1] : friction_at_a(m, j, part);
  });
  EffortDesign design(rows);
  design.append(effort_terms(rows, Settings{}));
  const std::vector<std::size_t> active = {
      index_of(design, "cable_spring at b"), index_of(design, "coulomb_friction at a"),
      index_of(design, "effort_offset at a"), index_of(design, "link_mass at lower")};
  Eigen::VectorXd weights(static_cast<Eigen::Index>(rows.rows.size()));
  for (Eigen::Index i = 0; i < weights.size(); ++i) weights[i] = 1.0 + static_cast<double>(i % 3);
  design.set_weights(weights);
  BlockCounts counts(rows.blocks);
  for (std::size_t b = 0; b < counts.size(); ++b) counts[b] = static_cast<double>(b % 4);
  // the oracle: the rows themselves, stacked, instead of sums by block
  std::vector<Eigen::Index> columns;
  for (const std::size_t t : active) {
    for (std::size_t c = 0; c < design.terms()[t].size(); ++c)
      columns.push_back(design.first_column(t) + static_cast<Eigen::Index>(c));
  }
  Eigen::MatrixXd A(weights.size(), static_cast<Eigen::Index>(columns.size()));
  Eigen::VectorXd y = design.target();
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const std::size_t block = rows.rows[static_cast<std::size_t>(i)].block;
    const double root = std::sqrt(weights[i] * counts[block]);
    for (Eigen::Index c = 0; c < A.cols(); ++c)
      A(i, c) = root * design.X()(i, columns[static_cast<std::size_t>(c)]);
    y[i] *= root;
  }
  const Eigen::VectorXd oracle = A.colPivHouseholderQr().solve(y);
  const EffortValues x = design.fit(active, counts);
  for (Eigen::Index c = 0; c < oracle.size(); ++c)
    EXPECT_NEAR(x[columns[static_cast<std::size_t>(c)]], oracle[c], 1e-8) << c;
  EXPECT_EQ((x.array() != 0.0).count(), oracle.size()) << "a term that takes no part has a value";
}

TEST(EffortFit, LossesOfTheJointsAddUpToAll) {
  const EffortRows rows = two_link_rows(friction_at_a);
  EffortDesign design(rows);
  design.append(effort_terms(rows, Settings{}));
  const EffortValues zero = EffortValues::Zero(design.columns());
  const std::vector<double> a = design.losses(zero, {0}), b = design.losses(zero, {1}),
                            all = design.losses(zero);
  double sum = 0.0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    EXPECT_NEAR(all[k], a[k] + b[k], 1e-9) << k;
    sum += all[k];
  }
  EXPECT_NEAR(sum, design.target().squaredNorm(), 1e-6);
}

TEST(EffortFit, AHeldGainStaysZeroAndItsJointSpeaksInTheRecordedUnit) {
  const EffortRows rows = two_link_rows(friction_at_a);
  EffortDesign design(rows);
  design.append(effort_terms(rows, Settings{}));
  const std::size_t gain = index_of(design, "torque_constant at a");
  const std::size_t at_a = index_of(design, "coulomb_friction at a"),
                    at_b = index_of(design, "viscous_friction at b");
  design.hold(gain, "A");
  design.scale(0, 2.0, true);
  EXPECT_EQ(design.terms()[at_a].units.front(), "A");
  EXPECT_EQ(design.terms()[at_b].units.front(), "N m s/rad");
  const EffortValues x = design.fit({gain, at_a}, BlockCounts(rows.blocks, 1.0));
  EXPECT_EQ(x[design.first_column(gain)], 0.0);
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const EffortRow& row = rows.rows[i];
    const double target = row.joint == 0 ? 2.0 * row.effort : row.effort - row.nominal;
    ASSERT_EQ(design.target()[static_cast<Eigen::Index>(i)], target) << i;
    ASSERT_EQ(design.recorded(i), row.joint == 0 ? 2.0 * row.effort : row.effort) << i;
  }
}

TEST(RobustWeights, AreOfEachJointAloneAndFallWithTheDistanceOfAnOutlier) {
  const EffortRows rows = two_link_rows(nothing);
  Eigen::VectorXd left(static_cast<Eigen::Index>(rows.rows.size()));
  for (Eigen::Index i = 0; i < left.size(); ++i)
    left[i] = (rows.rows[static_cast<std::size_t>(i)].joint == 0 ? 0.1 : 3.0) * sign(i % 4 - 1.5);
  left[0] = 10.0;  // of joint a
  const Eigen::VectorXd w = robust_weights(rows, left, 2.5);
  const double sigma = 1.4826 * 0.1;
  EXPECT_NEAR(w[2], 1.0 / (sigma * sigma), 1e-9);
  EXPECT_NEAR(w[1], w[2] / 900.0, 1e-9);
  EXPECT_NEAR(w[0], w[2] * 2.5 * sigma / 10.0, 1e-9);
}

// ---- what judges

TEST(EffortSplit, OfOneConditionIsTheEndOfEachOrEveryThirdRecording) {
  const ModelFolder model = test::pendulum(kTorque);
  for (int count = 1; count <= 7; ++count) {
    std::vector<EffortRecording> recordings;
    for (int r = 0; r < count; ++r)
      recordings.push_back(recorded(model, std::to_string(r) + ".csv", 2.0 + r, sines));
    const EffortRows rows = rows_of(recordings, nothing);
    const EffortSplit split = split_blocks(rows, EffortSettings{});
    std::vector<int> seen(recordings.size(), 0), held(recordings.size(), 0);
    for (std::size_t b = 0; b < split.fitted.size(); ++b) {
      const std::size_t r = rows.recording_of_block[b];
      EXPECT_EQ(split.fitted[b] + split.heldout[b], 1.0);
      if (split.heldout[b] != 0.0) ++held[r];
      if (count < 3 && split.fitted[b] != 0.0) {
        EXPECT_EQ(held[r], 0) << "fitted after what judges";
      }
      ++seen[r];
    }
    for (std::size_t r = 0; r < seen.size(); ++r) {
      const double share = count < 3 ? 0.4 : (r % 3 == 2 ? 1.0 : 0.0);
      EXPECT_NEAR(held[r], share * seen[r], count < 3 ? 1.0 : 0.0) << r << " of " << count;
    }
    EXPECT_EQ(split.heldout_names.size(), static_cast<std::size_t>(count < 3 ? count : count / 3));
    EXPECT_EQ(split.last_part, count < 3);
    EXPECT_EQ(split.heldout_names.front(), count < 3 ? "last 40 % of 0.csv" : "2.csv");
  }
}

TEST(EffortSplit, OfSeveralConditionsTheSmallestInSecondsJudges) {
  std::vector<EffortRecording> recordings;
  const char* conditions[] = {"light", "heavy", "light", "heavy"};
  const double seconds[] = {1.0, 6.0, 2.0, 1.0};
  for (std::size_t r = 0; r < 4; ++r) {
    recordings.push_back(recorded(test::pendulum(kTorque), std::to_string(r), seconds[r], sines));
    recordings.back().condition = conditions[r];
  }
  const EffortRows rows = rows_of(recordings, nothing);
  const EffortSplit split = split_blocks(rows, EffortSettings{});
  EXPECT_EQ(split.heldout_names, (Names{"0", "2"}));
  for (std::size_t b = 0; b < split.heldout.size(); ++b)
    EXPECT_EQ(split.heldout[b], rows.recording_of_block[b] % 2 == 0 ? 1.0 : 0.0);
}

// ---- the choice

TEST(CrossedGain, LooksAtNothingButTheFittedPart) {
  EffortRows rows = two_link_rows(friction_at_a);
  const EffortSplit split = split_blocks(rows, EffortSettings{});
  EffortGain before;
  for (const bool garbage : {false, true}) {
    for (EffortRow& row : rows.rows) {
      if (garbage && split.heldout[row.block] != 0.0) row.effort = 1e3;
    }
    EffortDesign design(rows);
    design.append(effort_terms(rows, Settings{}));
    const auto gain = [&](const std::string& words, std::size_t joint) {
      return crossed_gain(design, {}, {index_of(design, words)}, split.fitted, {joint}, Settings{},
                          1);
    };
    const EffortGain right = gain("coulomb_friction at a", 0);
    EXPECT_GT(right.low, 0.0);
    EXPECT_GT(right.share, 0.9);
    EXPECT_LE(gain("coulomb_friction at b", 1).low, 0.0) << "friction where there is none";
    EXPECT_EQ(gain("coulomb_friction at a", 1).gain, 0.0) << "a gain at another joint's rows";
    if (garbage) {
      EXPECT_EQ(right.gain, before.gain);
      EXPECT_EQ(right.low, before.low);
    }
    before = right;
  }
}

TEST(ChooseTerms, TakesOneAtATimeTheLargestFirst) {
  const EffortRows rows = two_link_rows([](const MotionSample& m, int j, double) {
    return j == 0 ? 0.1 * m.ddq[0] : 0.1 * sign(m.dq[1]);
  });
  const EffortOutcome outcome = explained(rows);
  EXPECT_EQ(named(outcome), (Names{"coulomb_friction at b", "rotor_inertia at a"}));
  ASSERT_EQ(outcome.log.size(), 2u) << testing::PrintToString(outcome.log);
  EXPECT_TRUE(outcome.log[0].starts_with("+ rotor_inertia at a:")) << outcome.log[0];
  EXPECT_TRUE(outcome.log[1].starts_with("+ coulomb_friction at b:")) << outcome.log[1];
}

TEST(ChooseTerms, KeepsToTheEffectsItWasGiven) {
  const EffortRows rows = two_link_rows(friction_at_a);
  for (const JudgedTerm& t : explained(rows, {"viscous_friction", "cable_spring"}).terms)
    EXPECT_TRUE(t.term.effect == "viscous_friction" || t.term.effect == "cable_spring");
  ChooseOptions options;
  options.without = {"coulomb_friction"};
  for (const JudgedTerm& t : explain_effort(rows, Settings{}, options).terms)
    EXPECT_NE(t.term.effect, "coulomb_friction");
}

/// A motor that turns both joints, by `ratio` of the first.
Missing coupled(double ratio) {
  return [ratio](const MotionSample& m, int j, double) {
    const double speed = m.dq[1] + ratio * m.dq[0];
    return (j == 0 ? ratio : 1.0) * (0.15 * sign(speed) + 0.05 * speed);
  };
}

TEST(ChooseTerms, FindsACoupledDriveAndWhichWayItTurns) {
  EXPECT_EQ(named(explained(two_link_rows(coupled(1.0)))),
            Names{"coupled_drive at a, b (ratio 1)"});
  EXPECT_EQ(named(explained(two_link_rows(coupled(-1.0)))),
            Names{"coupled_drive at a, b (ratio -1)"});
}

TEST(ChooseTerms, FindsNoCoupledDriveInTwoDrivesThatRubAlike) {
  const EffortOutcome outcome = explained(two_link_rows([](const MotionSample& m, int j, double) {
    const double speed = m.dq[static_cast<std::size_t>(j)];
    return 0.15 * sign(speed) + 0.05 * speed;
  }));
  EXPECT_EQ(named(outcome), (Names{"coulomb_friction at a", "coulomb_friction at b",
                                   "viscous_friction at a", "viscous_friction at b"}));
}

// ---- the judgement

TEST(Judge, WhatOnlyTheFittedPartShowsPredictsNothing) {
  const EffortOutcome outcome =
      explained(two_link_rows([](const MotionSample& m, int j, double part) {
        return part < 0.6 ? friction_at_a(m, j, part) : 0.0;
      }));
  ASSERT_FALSE(outcome.terms.empty());
  EXPECT_TRUE(named(outcome).empty()) << testing::PrintToString(named(outcome));
  EXPECT_FALSE(outcome.scores.front().beats_both());
  EXPECT_LE(outcome.terms.front().heldout_gain_low, 0.0);
}

TEST(Judge, WhatOnlyTheHeldOutPartShowsIsNotChosen) {
  const EffortOutcome outcome =
      explained(two_link_rows([](const MotionSample& m, int j, double part) {
        return part > 0.62 ? friction_at_a(m, j, part) : 0.0;
      }));
  EXPECT_TRUE(outcome.terms.empty()) << testing::PrintToString(outcome.log);
  EXPECT_GT(outcome.scores.front().nominal, 0.19);
}

TEST(Judge, ScoresAreTheHeldOutErrorsAndNoiseIsTheFloor) {
  const EffortRows rows = two_link_rows(friction_at_a);
  const EffortOutcome outcome = explained(rows);
  ASSERT_EQ(outcome.scores.size(), 2u);
  const EffortScore& a = outcome.scores[0];
  EXPECT_EQ(a.channel, "tau:a");
  EXPECT_NEAR(a.nominal, std::hypot(0.2, kNoise), 0.01);
  EXPECT_NEAR(a.patched, kNoise, 0.003);
  EXPECT_NEAR(a.noise, kNoise, 0.004);
  EXPECT_GT(a.constant, 5 * a.patched);
  EXPECT_TRUE(a.beats_both());
  EXPECT_EQ(outcome.left.size(), rows.rows.size());
  ASSERT_EQ(outcome.terms.size(), 1u);
  // with the term goes what was missing, but noise and what the tolerances would take
  EXPECT_GT(outcome.terms.front().heldout_gain, 0.9);
  EXPECT_LT(outcome.terms.front().heldout_gain, 0.995);
  EXPECT_FALSE(outcome.terms.front().spans_null);
}

TEST(Judge, IntervalsCoverAsOftenAsTheySay) {
  int covered = 0, drawn = 0;
  double quiet = 0.0, loud = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const EffortRows rows = two_link_rows(friction_at_a, 0.05, seed);
    const EffortOutcome outcome = explained(rows, {"coulomb_friction"});
    for (const JudgedTerm& t : outcome.terms) {
      if (in_words(t.term) != "coulomb_friction at a") continue;
      const JudgedValue& v = t.values.front();
      ++drawn, covered += v.low <= 0.2 && 0.2 <= v.high ? 1 : 0;
      quiet += v.high - v.low;
    }
  }
  EXPECT_EQ(drawn, 20);
  EXPECT_GE(covered, 16) << "95 % of 20; fewer than 16 by chance once in 3000 times";
  const EffortOutcome noisy = explained(two_link_rows(friction_at_a, 0.2), {"coulomb_friction"});
  ASSERT_FALSE(noisy.terms.empty());
  loud = noisy.terms.front().values.front().high - noisy.terms.front().values.front().low;
  // four times the noise: wider, but no more than so, as the tolerances' part does not grow
  EXPECT_GT(loud / (quiet / 20), 1.5);
  EXPECT_LT(loud / (quiet / 20), 4.5);
}

/// Back and forth at one speed: dry and viscous friction are the same column. No instant is at a
/// turn.
double zigzag(int j, double t) {
  const double phase = (t + 0.003) / 3.0 - std::floor((t + 0.003) / 3.0);
  return j == 0 ? 4.0 * std::abs(phase - 0.5) - 1.0 : sines(1, t);
}

TEST(Judge, TiesTheNamesThatOneSpeedCannotTellApart) {
  const auto tied = [](const Angle& angle) {
    const EffortRows rows =
        rows_of({recorded(test::two_links(kTorque), "one.csv", 20.0, angle)}, friction_at_a);
    const EffortOutcome outcome = explained(rows, {"coulomb_friction", "viscous_friction"});
    EXPECT_EQ(outcome.terms.size(), 1u) << testing::PrintToString(outcome.log);
    Names names = outcome.terms.empty() ? Names{} : outcome.terms.front().equally_good;
    if (!outcome.terms.empty()) names.push_back(outcome.terms.front().term.effect);
    return names;
  };
  const Names one_speed = tied(zigzag), many = tied(sines);
  const auto has = [](const Names& names, const char* name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  EXPECT_TRUE(has(one_speed, "viscous_friction")) << testing::PrintToString(one_speed);
  EXPECT_TRUE(has(one_speed, "coulomb_friction")) << testing::PrintToString(one_speed);
  EXPECT_FALSE(has(many, "viscous_friction")) << "at many speeds they are told apart";
}

TEST(Judge, TiesNoNameOfAnotherJoint) {
  // joint b has no motor, so that its motor's constant is no name there; its friction shows in the
  // fitted part alone, so that on the rest any name does as well
  EffortRecording recording = recorded(test::two_links(kTorque), "one.csv", 20.0, sines);
  recording.channels[1].column.clear();
  const EffortRows rows = rows_of({recording}, [](const MotionSample& m, int j, double part) {
    return j == 1 && part < 0.6 ? 0.2 * sign(m.dq[1]) : 0.0;
  });
  const EffortOutcome outcome = explained(rows);
  ASSERT_FALSE(outcome.terms.empty());
  for (const JudgedTerm& t : outcome.terms) {
    ASSERT_EQ(t.term.where.front(), "b") << in_words(t.term);
    EXPECT_FALSE(t.equally_good.empty());
    for (const std::string& name : t.equally_good) EXPECT_NE(name, "torque_constant");
  }
}

}  // namespace
}  // namespace sanso::diagnose
