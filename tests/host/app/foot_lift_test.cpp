// A foot that the reference lifts and the robot leaves on the floor, by the robot's own estimate.
#include "host/app/foot_lift.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sanso::app {
namespace {

/// The left leg drawn up by `share` of a bend of 0.6 rad, its sole level.
model::State drawn_up(double share) {
  constexpr int kLHipPitch = 8, kLKnee = 9, kLAnklePitch = 10;
  model::State x = model::neutral_state();
  x[model::kXJoint + kLHipPitch] -= 0.3 * share;
  x[model::kXJoint + kLKnee] += 0.6 * share;
  x[model::kXJoint + kLAnklePitch] += 0.3 * share;
  return x;
}

learn::Episode lifting(double share, double wanted = 1.0) {
  learn::Episode episode;
  const model::State x_ref = drawn_up(wanted);
  for (int tick = 0; tick < 20; ++tick) {
    wire::Observation o;
    o.trial_tick = tick;
    o.x = drawn_up(share);
    episode.ticks.push_back(o);
    std::array<float, model::kNx> row{};
    for (int i = 0; i < model::kNx; ++i)
      row[static_cast<std::size_t>(i)] = static_cast<float>(x_ref[i]);
    episode.reference.push_back(row);
  }
  return episode;
}

TEST(FootLift, IsOneWhenTheFootRisesAsTheReferenceAndZeroWhenItStays) {
  EXPECT_NEAR(lifted_share(lifting(1.0)), 1.0, 1e-4);
  EXPECT_NEAR(lifted_share(lifting(0.0)), 0.0, 1e-9);
  const double half = lifted_share(lifting(0.5));
  EXPECT_GT(half, 0.1);
  EXPECT_LT(half, 0.9);
  EXPECT_NEAR(lifted_share(lifting(1.3)), 1.0, 1e-9) << "higher than asked makes nothing good";
}

TEST(FootLift, IsNotKnownWhereTheReferenceLiftsNoFoot) {
  EXPECT_LT(lifted_share(lifting(1.0, 0.0)), 0.0);
}

TEST(FootLift, DoesNotReadTheHeightOfTheFloorNorWhatOnlyTheWorldKnows) {
  learn::Episode episode = lifting(0.5);
  const double before = lifted_share(episode);
  for (wire::Observation& o : episode.ticks) o.x[2] += 0.05;
  learn::TrueSample truth;
  truth.foot_clearance_m = {0.5F, 0.5F};
  episode.truth.assign(episode.ticks.size(), truth);
  EXPECT_NEAR(lifted_share(episode), before, 1e-9);
}

}  // namespace
}  // namespace sanso::app
