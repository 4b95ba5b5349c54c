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

/// Where the legs' links stand while holding, and where the controller believes them.
struct Stand {
  model::Input truth = model::Input::Zero(), belief = model::Input::Zero();
};

Settings settings_with(const JointOffsets& believed) {
  Settings settings;
  settings.bus.offset_rad = believed;
  return settings;
}

void set_horns(testing::EmulatedController& c, const JointOffsets& horns) {
  for (int id = 1; id <= emulator::kNumServos; ++id) {
    emulator::ServoSetup servo;
    servo.id = id;
    servo.horn_error_rad = horns[static_cast<std::size_t>(id - 1)];
    c.robot.set_up(servo);
  }
}

Stand stand_with(const JointOffsets& horns, const JointOffsets& believed) {
  testing::EmulatedController c("nominal", settings_with(believed));
  set_horns(c, horns);
  EXPECT_TRUE(c.stand());
  return {model::joints(c.truth()), model::joints(c.seen().x)};
}

double apart(const model::Input& a, const model::Input& b) { return (a - b).cwiseAbs().maxCoeff(); }

TEST(Offsets, TheLinksStandAsThoseOfARobotWithStraightHorns) {
  // gravity bends every stand a little, this one as much as the straight one
  const Stand straight = stand_with({}, {});
  const Stand corrected = stand_with(crooked(), crooked());
  const Stand ignored = stand_with(crooked(), {});
  EXPECT_LT(apart(corrected.truth, straight.truth), 0.01);
  EXPECT_LT(apart(corrected.belief, corrected.truth), 0.01);
  EXPECT_GT(apart(ignored.truth, straight.truth), 0.02) << "the horns are crooked indeed";
  EXPECT_GT(apart(ignored.belief, ignored.truth), 0.03);
}

TEST(Offsets, ARobotThatIsAdoptedHoldsTheGoalsThatItsServosHad) {
  testing::EmulatedController c("nominal", settings_with(crooked()));
  set_horns(c, crooked());
  ASSERT_TRUE(c.stand());
  const model::Input before = model::joints(c.truth());
  c.start();
  ASSERT_TRUE(c.run_until(wire::SupervisorState::hold, 12)) << "fault " << c.seen().fault;
  c.ticks(200);
  EXPECT_LT(apart(model::joints(c.truth()), before), 0.01);
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
