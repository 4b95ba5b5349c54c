// Clauses are judged by what really was: a foot that stands is down, wherever the floor is.
#include "host/app/motion_judge.h"

#include <gtest/gtest.h>

#include "host/motion/make/body_kinematics.h"

namespace sanso::app {
namespace {

/// A robot that stands still on a floor `below_m` lower than where its trial began.
learn::Episode standing(double below_m) {
  learn::Episode episode;
  for (int tick = 0; tick < 20; ++tick) {
    wire::Observation o;
    o.trial_tick = tick;
    learn::TrueSample truth;
    truth.x[2] = -motion::body_points(truth.x).sole_corners(0)[0][2] + truth.x[2] - below_m;
    truth.foot_load_N = {17.0F, 17.0F};
    episode.ticks.push_back(o);
    episode.truth.push_back(truth);
  }
  return episode;
}

TEST(MotionJudge, AFootThatStandsIsDownWhereverTheFloorIs) {
  for (const double below_m : {0.0, 0.01, -0.004}) {
    const motion::MotionEpisode seen = seen_from_outside(standing(below_m));
    ASSERT_EQ(seen.samples.size(), 20U);
    for (const motion::EpisodeSample& sample : seen.samples)
      for (const double clearance : sample.foot_clearance_m) EXPECT_EQ(clearance, 0.0) << below_m;
  }
}

TEST(MotionJudge, WithoutTruthTheEstimateOnAFlatFloorIsAllThereIs) {
  learn::Episode episode = standing(0.0);
  for (std::size_t i = 0; i < episode.ticks.size(); ++i) {
    episode.ticks[i].x = episode.truth[i].x;
    episode.ticks[i].x[2] += 0.02;
  }
  episode.truth.clear();
  for (const motion::EpisodeSample& sample : seen_from_outside(episode).samples)
    EXPECT_NEAR(sample.foot_clearance_m[0], 0.02, 1e-9);
}

}  // namespace
}  // namespace sanso::app
