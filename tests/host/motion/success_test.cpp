// Success clauses: an episode that does it holds them all; each way to fail is named by its own
// clause.
#include "host/motion/success.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host/motion/motion.h"

namespace sanso::motion {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

/// Follows the reference with both feet down and half the weight on each.
MotionEpisode following(const Motion& motion) {
  MotionEpisode episode;
  episode.completed = true;
  episode.cost = 5.0;
  for (const auto& x : motion.reference().x) {
    EpisodeSample sample;
    sample.x = x;
    sample.foot_clearance_m = {0.0, 0.0};
    sample.foot_load_N = {15.0, 15.0};
    sample.foot_m = {Eigen::Vector2d(0, -0.035), Eigen::Vector2d(0, 0.035)};
    episode.samples.push_back(sample);
  }
  return episode;
}

/// Lifts a foot by `height` from second `from` to `to`, the other one carrying all.
void lift(MotionEpisode& episode, int side, double from_s, double to_s, double height) {
  for (std::size_t k = 0; k < episode.samples.size(); ++k) {
    const double t = static_cast<double>(k) * episode.dt_s;
    if (t < from_s || t >= to_s) continue;
    episode.samples[k].foot_clearance_m[side] = height;
    episode.samples[k].foot_load_N[side] = 0.0;
    episode.samples[k].foot_load_N[1 - side] = 30.0;
  }
}

std::vector<std::string> failures(const Motion& motion, const MotionEpisode& episode) {
  std::vector<std::string> names;
  for (const auto& c : evaluate(motion, episode).clauses) {
    if (!c.holds) names.push_back(c.clause.measure);
  }
  return names;
}

TEST(Success, StandingOnTheReferenceHolds) {
  const Motion stand = MotionLibrary().load("stand");
  EXPECT_THAT(failures(stand, following(stand)), IsEmpty());
  EXPECT_TRUE(evaluate(stand, following(stand)).succeeded());
}

TEST(Success, EachFailureIsNamedByItsClause) {
  const Motion stand = MotionLibrary().load("stand");
  MotionEpisode episode = following(stand);
  episode.cost = 351;
  EXPECT_THAT(failures(stand, episode), ElementsAre("cost"));
  episode = following(stand);
  episode.completed = false;
  EXPECT_THAT(failures(stand, episode), ElementsAre("completed"));
  episode = following(stand);
  episode.samples[200].x[0] += 0.05;
  EXPECT_THAT(failures(stand, episode), ElementsAre("base_drift_m"));
  episode = following(stand);
  episode.samples[200].x.segment<4>(model::kXQuat) = math::quat_exp({0, 0.1, 0});
  EXPECT_THAT(failures(stand, episode), ElementsAre("tilt_deg"));
  episode = following(stand);
  lift(episode, 0, 1.0, 1.5, 0.01);
  EXPECT_THAT(failures(stand, episode), ElementsAre("both_feet_loaded_share"));
}

TEST(Success, SquatNeedsItsDepthItsReturnAndItsFeet) {
  const Motion squat = MotionLibrary().load("squat");
  EXPECT_THAT(failures(squat, following(squat)), IsEmpty());
  MotionEpisode shallow = following(squat);
  const double top = shallow.samples.front().x[2];
  for (auto& s : shallow.samples) s.x[2] = top + 0.6 * (s.x[2] - top);
  EXPECT_THAT(failures(squat, shallow), ElementsAre("depth_share"));
  MotionEpisode sagged = following(squat);
  sagged.samples.back().x[2] -= 0.02;
  EXPECT_THAT(failures(squat, sagged), ElementsAre("return_height_error_m"));
  MotionEpisode slipped = following(squat);
  slipped.samples.back().foot_m[1].x() += 0.02;
  EXPECT_THAT(failures(squat, slipped), ElementsAre("foot_slip_m"));
}

TEST(Success, OneLegNeedsAnUnbrokenLift) {
  const Motion one_leg = MotionLibrary().load("one_leg");
  MotionEpisode episode = following(one_leg);
  lift(episode, 1, 3.0, 4.2, 0.02);
  lift(episode, 1, 4.3, 5.5, 0.02);
  EXPECT_THAT(failures(one_leg, episode), ElementsAre("longest_lift_s"));
  lift(episode, 1, 4.1, 4.4, 0.02);
  EXPECT_THAT(failures(one_leg, episode), IsEmpty());
  // something other than a sole holds the robot up
  for (auto& s : episode.samples) s.foot_load_N = {0.0, 0.0};
  EXPECT_THAT(failures(one_leg, episode), ElementsAre("single_support_share"));
}

TEST(Success, WalkCountsSwingsThatClearTheGround) {
  const Motion walk = MotionLibrary().load("walk_forward");
  MotionEpisode episode = following(walk);
  for (int step = 0; step < 6; ++step) lift(episode, step % 2, 2.0 + step, 2.5 + step, 0.012);
  EXPECT_THAT(failures(walk, episode), IsEmpty());
  MotionEpisode dragging = following(walk);
  for (int step = 0; step < 6; ++step) lift(dragging, step % 2, 2.0 + step, 2.5 + step, 0.004);
  EXPECT_THAT(failures(walk, dragging), ElementsAre("steps", "lowest_step_clearance_m"));
  MotionEpisode astray = episode;
  for (auto& s : astray.samples) s.x[1] += 0.2;
  EXPECT_THAT(failures(walk, astray), ElementsAre("cross_drift_m"));
}

TEST(Success, JogNeedsFlight) {
  const Motion jog = MotionLibrary().load("jog");
  MotionEpisode episode = following(jog);
  // feet in turn, with 30 ms between in which nothing touches the ground
  int step = 0;
  for (double t = jog.window.from_s; t < jog.window.to_s; t += 0.28, ++step) {
    lift(episode, step % 2, t, t + 0.28, 0.012);
    for (std::size_t k = 0; k < episode.samples.size(); ++k) {
      const double s = static_cast<double>(k) * episode.dt_s;
      if (s >= t && s < t + 0.03) episode.samples[k].foot_load_N = {0.0, 0.0};
    }
  }
  EXPECT_THAT(failures(jog, episode), Not(Contains("flight_share")));
  for (auto& s : episode.samples) {
    if (s.foot_load_N[0] + s.foot_load_N[1] == 0.0) s.foot_load_N = {2.0, 2.0};
  }
  EXPECT_THAT(failures(jog, episode), Contains("flight_share"));
}

TEST(Success, WhatNobodyMeasuredIsNotTakenAsDone) {
  const Motion stand = MotionLibrary().load("stand");
  MotionEpisode episode = following(stand);
  episode.samples[300].foot_load_N = {EpisodeSample::kUnknown, EpisodeSample::kUnknown};
  const Verdict verdict = evaluate(stand, episode);
  EXPECT_FALSE(verdict.succeeded());
  ASSERT_EQ(verdict.failures().size(), 1u);
  EXPECT_THAT(verdict.failures()[0], HasSubstr("both_feet_loaded_share not measured"));
}

TEST(Success, AnEmptyEpisodeFailsEveryClause) {
  const Motion squat = MotionLibrary().load("squat");
  EXPECT_EQ(evaluate(squat, {}).failures().size(), squat.success.size());
}

TEST(Success, AWaivedClauseIsShownAndDoesNotCount) {
  const Motion jog = MotionLibrary().load("jog");
  // stands all the time: neither steps nor flight
  const Verdict verdict = evaluate(jog, following(jog));
  bool flight_shown = false;
  for (const auto& c : verdict.clauses) {
    if (c.clause.measure != "flight_share") continue;
    flight_shown = true;
    EXPECT_FALSE(c.holds);
    EXPECT_FALSE(c.counts_against());
    EXPECT_THAT(c.text(), HasSubstr("waived"));
  }
  EXPECT_TRUE(flight_shown);
  EXPECT_THAT(verdict.failures(), Not(Contains(HasSubstr("flight_share"))));
  EXPECT_THAT(verdict.failures(), Contains(HasSubstr("steps")));  // the others still count
  EXPECT_FALSE(verdict.succeeded());
}

}  // namespace
}  // namespace sanso::motion
