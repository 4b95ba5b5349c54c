// Offsets by physics: the horns of an emulated robot sit crookedly, and the links have to stand as
// commanded all the same. Truth is the angle of the links, which no servo knows.
#include <gtest/gtest.h>

#include "tests/firmware/support/emulated_controller.h"

namespace sanso::firmware {
namespace {

/// Two degrees and less at each leg joint, another way at each.
JointOffsets crooked() {
  JointOffsets offsets{};
  for (int id = 7; id <= 18; ++id)
    offsets[static_cast<std::size_t>(id - 1)] = 0.035 * ((id * 7) % 5 - 2) / 2.0;
  return offsets;
}

/// Largest distance of a leg's link from the pose commanded while holding, and of what the
/// controller believes from the truth.
struct Errors {
  double pose = 0, belief = 0;
};

Errors stand_with(const JointOffsets& believed) {
  Settings settings;
  settings.bus.offset_rad = believed;
  testing::EmulatedController c("nominal", settings);
  for (int id = 1; id <= emulator::kNumServos; ++id) {
    emulator::ServoSetup servo;
    servo.id = id;
    servo.horn_error_rad = crooked()[static_cast<std::size_t>(id - 1)];
    c.robot.set_up(servo);
  }
  EXPECT_TRUE(c.stand());
  Errors worst;
  const model::Input truth = model::joints(c.truth());
  const model::Input seen = model::joints(c.seen().x);
  for (int j = 0; j < model::kNumJoints; ++j) {
    worst.pose = std::max(worst.pose, std::abs(truth[j] - testing::standing_pose()[j]));
    worst.belief = std::max(worst.belief, std::abs(truth[j] - seen[j]));
  }
  return worst;
}

TEST(Offsets, TheLinksStandAsCommandedAndAreSeenAsTheyStand) {
  const Errors with = stand_with(crooked()), without = stand_with(JointOffsets{});
  EXPECT_LT(with.belief, 0.01);
  EXPECT_GT(without.belief, 0.03) << "the horns are crooked indeed";
  EXPECT_LT(with.pose, without.pose);
}

TEST(OpenCrImu, ARobotWithNothingButItsOwnSensorStands) {
  Settings settings;
  settings.imu.from_board = true;
  testing::EmulatedController c("nominal", settings);
  c.without_hid = true;
  EXPECT_TRUE(c.stand()) << "fault " << c.seen().fault;
  c.ticks(200);
  EXPECT_EQ(c.controller->state(), wire::SupervisorState::hold) << "fault " << c.seen().fault;
}

}  // namespace
}  // namespace sanso::firmware
