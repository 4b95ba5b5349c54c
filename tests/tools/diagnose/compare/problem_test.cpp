// What is compared: shots that tile the data, entries in their order, placed candidates, nuisances.
#include "tools/diagnose/compare/problem.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/compare/prediction_error.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

using namespace test;

TEST(Problem, ShotsLieInTheirRecordingsOneAfterTheOther) {
  const SmallComparison c = compared(two_links(kNoisyServo), {}, {"coulomb_friction"}, 1, 3);
  std::size_t expected = 0;
  for (std::size_t k = 0; k < c.problem->shots.size(); ++k) {
    const Shot& shot = c.problem->shots[k];
    const Source& source = c.problem->sources[shot.source];
    EXPECT_EQ(shot.offset, expected);
    expected += shot.rows * c.problem->channels.size();
    EXPECT_LT(shot.window.last, source.drive.rows());
    EXPECT_EQ((shot.window.last - shot.window.first) / shot.stride, shot.rows);
    if (k > 0 && shot.source == c.problem->shots[k - 1].source) {
      EXPECT_GE(shot.window.first, c.problem->shots[k - 1].window.last);
    }
  }
  EXPECT_EQ(c.problem->size, expected);
  EXPECT_GT(c.problem->used_share, 0.8);
  EXPECT_LE(c.problem->used_share, 1.0 + 1e-9);
}

TEST(Problem, EveryRecordingIsItsOwnHeldOutGroup) {
  const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, 1, 4);
  EXPECT_EQ(c.problem->groups, 4u);
  std::set<std::pair<std::size_t, std::size_t>> pairs;
  for (const Shot& shot : c.problem->shots) pairs.insert({shot.source, shot.group});
  EXPECT_EQ(pairs.size(), 4u);
}

TEST(Problem, OneRecordingIsCutIntoGroups) {
  const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, 1, 1, 8.0);
  std::set<std::size_t> groups;
  for (const Shot& shot : c.problem->shots) groups.insert(shot.group);
  EXPECT_EQ(groups.size(), c.problem->groups);
  EXPECT_GE(c.problem->groups, 2u);
}

TEST(Problem, StartsOfShotsAreTheSmoothedMotion) {
  const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, 1);
  for (const Shot& shot : c.problem->shots) {
    const MeasuredMotion& motion = c.problem->sources[shot.source].motion;
    EXPECT_EQ(shot.window.q[0], motion.q[0][shot.window.first]);
    EXPECT_EQ(shot.window.dq[0], motion.dq[0][shot.window.first]);
  }
}

TEST(Problem, ResidualOfNothingIsTheMeasurementOverItsDeviation) {
  const SmallComparison c = compared(two_links(kNoisyServo), {}, {"coulomb_friction"}, 1);
  const Shot& shot = c.problem->shots[3];
  Prediction zero;
  zero.first = shot.window.first;
  zero.rows = shot.window.last - shot.window.first + 1;
  for (auto* channel : {&zero.q, &zero.dq, &zero.tau, &zero.i, &zero.pwm})
    channel->assign(2 * zero.rows, 0.0);
  Eigen::VectorXd r = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(c.problem->size), -7.0);
  whiten_residual(c.problem, shot, zero, {}, r);
  const Source& source = c.problem->sources[shot.source];
  for (std::size_t ch = 0; ch < c.problem->channels.size(); ++ch) {
    const Observed& channel = c.problem->channels[ch];
    for (std::size_t k = 0; k < shot.rows; ++k) {
      const std::size_t row = recorded_row(shot, k);
      EXPECT_NEAR(rows_of(r, shot, ch)[k],
                  measured(source, channel, row) / c.problem.scales.sigma[ch], 1e-9);
    }
  }
}

TEST(Problem, CellsThatWereNotSampledSayNothing) {
  auto recordings = recordings_of(pendulum(kNoisyServo), 1, 4.0, 1);
  const auto span = recordings[0].find("q:a");
  std::vector<double> q(span.begin(), span.end());
  for (std::size_t k = 100; k < 150; k += 2) q[k] = NAN;
  recordings[0].set("q:a", q);
  const ModelFolder model = pendulum(kNoisyServo);
  const SmallComparison c(model, recordings, noise_of(model), {"coulomb_friction"});
  const Eigen::VectorXd r = prediction_error(c.problem, c.library, nominal(c));
  EXPECT_TRUE(r.allFinite());
  EXPECT_GT((r.array() == 0.0).count(), 10);
}

TEST(Problem, AnInstantIsNearTheShotThatHoldsItAndItsNeighbours) {
  const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, 1, 1);
  int near = 0;
  for (const Shot& shot : c.problem->shots) near += near_instant(*c.problem, shot, 2.1);
  EXPECT_EQ(near, 3);
}

TEST(Library, IsPlacedAtEveryJointAndOnlyWhatWasAskedFor) {
  const SmallComparison c =
      compared(two_links(kNoisyServo), {}, {"coulomb_friction", "backlash"}, 1);
  EXPECT_GE(c.of("coulomb_friction", {0}), 0);
  EXPECT_GE(c.of("coulomb_friction", {1}), 0);
  for (const Candidate& candidate : c.library.candidates) {
    EXPECT_TRUE(candidate.effect == "coulomb_friction" || candidate.effect == "backlash");
    ASSERT_FALSE(candidate.probes.empty());
    for (const auto& probe : candidate.probes) {
      ASSERT_EQ(probe.size(), candidate.parameters.size());
      for (std::size_t i = 0; i < probe.size(); ++i) {
        EXPECT_GE(probe[i], candidate.parameters[i].low);
        EXPECT_LE(probe[i], candidate.parameters[i].high);
      }
    }
  }
}

TEST(Library, OneNumberStandsForJointsOfOneKindAndScaleOnly) {
  const auto tied = [](const ModelFolder& model, const char* effect) {
    const SmallComparison c(model, recordings_of(model, 1, 4.0, 1), noise_of(model), {effect});
    return std::any_of(c.library.candidates.begin(), c.library.candidates.end(),
                       [](const Candidate& k) { return k.joints.size() == 2; });
  };
  ModelFolder model = two_links(kNoisyServo);
  EXPECT_TRUE(tied(model, "coulomb_friction"));
  EXPECT_TRUE(tied(model, "command_delay"));
  // a drive of an eighth of the torque: friction in N m is another, a delay is a delay
  model.joints[1].resistance *= 8.0;
  EXPECT_FALSE(tied(model, "coulomb_friction"));
  EXPECT_TRUE(tied(model, "command_delay"));
}

TEST(Library, APassiveJointHasNoRotorAndNoNumberOfADrive) {
  ModelFolder model = two_links(kNoisyServo);
  model.joints[0].actuator = Actuator::passive;
  const SmallComparison c(model, recordings_of(model, 1, 4.0, 1), noise_of(model),
                          {"rotor_inertia", "coulomb_friction"});
  for (const Candidate& candidate : c.library.candidates) {
    EXPECT_EQ(candidate.joints.size(), 1U) << candidate.effect;
    if (candidate.effect == "rotor_inertia") {
      EXPECT_EQ(candidate.joints, std::vector<std::size_t>{1});
    }
  }
  EXPECT_GE(c.of("rotor_inertia", {1}), 0);
  EXPECT_GE(c.of("coulomb_friction", {0}), 0);
}

TEST(Library, WhatCannotBeTestedHereIsSaidWithAReason) {
  const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, 1);
  const Placement all = place_library(*c.problem, {});
  for (const auto& [effect, because] : all.untestable) {
    EXPECT_FALSE(because.empty()) << effect;
    EXPECT_TRUE(std::none_of(all.candidates.begin(), all.candidates.end(), [&](const Candidate& k) {
      return k.effect == effect;
    })) << effect;
  }
  EXPECT_GT(all.candidates.size(), 20u);
}

TEST(Nuisances, AtTheirNullChangeNothingAndAreLinearInTheirValue) {
  const SmallComparison c = compared(two_links(kNoisyServo), {}, {"coulomb_friction"}, 1);
  const Eigen::VectorXd plain = prediction_error(c.problem, c.library, Model{});
  EXPECT_EQ(prediction_error(c.problem, c.library, nominal(c)), plain);
  ASSERT_FALSE(c.library.nuisances.empty());
  for (const Nuisance& n : c.library.nuisances) {
    EXPECT_GT(n.tolerance, 0.0) << n.name;
    const std::vector<double> at = n.theta(0.4), twice = n.theta(0.8);
    for (std::size_t i = 0; i < n.null.size(); ++i) {
      EXPECT_EQ(n.theta(0.0)[i], n.null[i]) << n.name;
      EXPECT_NEAR(twice[i] - n.null[i], 2.0 * (at[i] - n.null[i]), 1e-12) << n.name;
    }
  }
}

// A link that is a little longer than stated holds the next joint farther out; where the first
// joint stands changes nothing that is measured.
TEST(Nuisances, TheNextJointIsAsFarOutAsALengthIsKnown) {
  const SmallComparison c = compared(two_links(kNoisyServo), {}, {"coulomb_friction"}, 1);
  const SimParams& stated = c.problem->sources.front().nominal;
  std::vector<const Nuisance*> places;
  for (const Nuisance& n : c.library.nuisances)
    if (n.name.rfind("place of ", 0) == 0) places.push_back(&n);
  ASSERT_EQ(places.size(), 1U);
  EXPECT_EQ(places.front()->name, "place of " + c.problem->joints[1]);
  EXPECT_EQ(places.front()->tolerance, ToleranceSettings{}.length);
  SimParams longer = stated;
  places.front()->apply(longer, 0.015);
  EXPECT_EQ(longer.tree.joints[0].p_parent_joint, stated.tree.joints[0].p_parent_joint);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(longer.tree.joints[1].p_parent_joint[k],
                1.015 * stated.tree.joints[1].p_parent_joint[k], 1e-12);
}

TEST(Hold, PutsTheCommandBeforeInThePlaceOfALostOne) {
  const SmallComparison c = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, 1);
  const std::vector<double>& sent = c.problem->sources[1].drive.joints[0].command;
  const Problem received = with_lost(c.problem, {{1, 0, 51}, {1, 0, 50}, {1, 0, 200}});
  const std::vector<double>& got = received->sources[1].drive.joints[0].command;
  for (std::size_t k = 0; k < sent.size(); ++k) {
    const double expected = k == 50 || k == 51 ? sent[49] : k == 200 ? sent[199] : sent[k];
    EXPECT_EQ(got[k], expected) << k;
  }
  EXPECT_EQ(received->sources[0].drive.joints[0].command,
            c.problem->sources[0].drive.joints[0].command);
}

TEST(Problem, ShotsThatAreChosenTakeWhatIsKnownOfThemAlong) {
  SmallComparison c = compared(two_links(kNoisyServo), {}, {"coulomb_friction"}, 1);
  Random random(4);
  c.problem.correction.error.resize(static_cast<Eigen::Index>(c.problem->size));
  for (double& e : c.problem.correction.error) e = random.normal();
  const std::vector<std::size_t> chosen{5, 1, 2};
  const Problem some = with_shots(c.problem, chosen);
  const std::size_t all = c.problem->channels.size();
  const Eigen::VectorXd before = prediction_error(c.problem, c.library, nominal(c)),
                        after = prediction_error(some, c.library, nominal(c));
  std::size_t size = 0;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    EXPECT_EQ(rows_of(after, some->shots[i], 0, all),
              rows_of(before, c.problem->shots[chosen[i]], 0, all));
    size += c.problem->shots[chosen[i]].rows * all;
  }
  EXPECT_EQ(some->size, size);
}

TEST(Rescaled, ThereAndBackIsWhereItWas) {
  SmallComparison c = compared(two_links(kNoisyServo), {}, {"coulomb_friction"}, 1);
  const Eigen::VectorXd r = prediction_error(c.problem, c.library, nominal(c));
  const Scales before = c.problem.scales;
  c.problem.scales = overdispersed(c.problem, {9.0, 4.0});
  EXPECT_NEAR(c.problem.scales.sigma[0] / before.sigma[0], 3.0, 1e-12);
  EXPECT_EQ(overdispersed(c.problem, {1e-6, 1e-6}).sigma, floors(*c.problem).sigma)
      << "never below the floor";
  const Eigen::VectorXd told = rescaled(*c.problem, r, before, c.problem.scales);
  EXPECT_LT((told - prediction_error(c.problem, c.library, nominal(c))).norm(), 1e-9);
  EXPECT_LT((rescaled(*c.problem, told, c.problem.scales, before) - r).norm(), 1e-9);
}

}  // namespace
}  // namespace sanso::diagnose
