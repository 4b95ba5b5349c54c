// Arming on the emulated robot: whatever comes first, is lost, damaged or elsewhere, no limb jumps;
// what cannot be known is refused with a number.
#include <gtest/gtest.h>

#include "tests/firmware/support/edges.h"

namespace sanso::firmware {
namespace {

using emulator::FaultKind;
using testing::EmulatedController;
using testing::RobotPort;
using testing::switch_fault;
using testing::torque_sum;
using wire::CommandKind;
using wire::SupervisorState;

struct Jerk {
  bool accepted = false;
  std::uint16_t reason = 0;
  double step_rad = 0, speed_rad_s = 0;
};

/// Arms a robot that a person holds in `pose`, and looks at the half second after it.
Jerk arm_and_look(EmulatedController& c) {
  Jerk jerk;
  model::Input previous = model::joints(c.truth());
  c.handover->commands.push({77, CommandKind::arm, 1, policy::LayerSwitches::kAll, 0});
  for (int i = 0; i < 50 + 40; ++i) {
    c.tick();
    const bool torque = c.controller->torque_on();
    if (torque)
      jerk.step_rad = std::max(jerk.step_rad, (c.seen().u_out - previous).cwiseAbs().maxCoeff());
    previous = c.seen().u_out;
    for (const double dq : c.robot.truth().dq)
      if (torque) jerk.speed_rad_s = std::max(jerk.speed_rad_s, std::abs(dq));
  }
  jerk.accepted = c.last_ack.sequence == 77 && c.last_ack.accepted != 0;
  jerk.reason = c.last_ack.sequence == 77 ? c.last_ack.reason : 0;
  return jerk;
}

/// Held in the crouch, far from the first pose, with old goals elsewhere.
void be_held_in_crouch(EmulatedController& c) {
  std::array<double, 12> legs{};
  const model::Input crouch = crouch_pose();
  std::copy_n(crouch.data(), 12, legs.begin());
  c.robot.place(emulator::with_legs(legs));
  c.robot.hold(true);
  c.upload(testing::still_primitives(testing::standing_pose(), 3.0));
}

constexpr double kMaxStep_rad = 0.15, kMaxSpeed_rad_s = 1.5;

void expect_calm(const Jerk& jerk) {
  if (!jerk.accepted) {
    EXPECT_NE(jerk.reason, 0) << "a refusal has a number";
  }
  EXPECT_LE(jerk.step_rad, kMaxStep_rad);
  EXPECT_LE(jerk.speed_rad_s, kMaxSpeed_rad_s);
}

TEST(ArmingGate, HoweverEarlyTheCommandComesNothingJumps) {
  for (int wait = 0; wait <= 10; ++wait) {
    SCOPED_TRACE(wait);
    EmulatedController c("nominal");
    be_held_in_crouch(c);
    ASSERT_TRUE(c.run_until(SupervisorState::idle, 10));
    c.ticks(wait);
    const Jerk jerk = arm_and_look(c);
    EXPECT_TRUE(jerk.accepted) << jerk.reason;
    expect_calm(jerk);
    // the same after a clear
    c.handover->emergency_stop = true;
    c.ticks(20);
    ASSERT_EQ(c.command(CommandKind::clear_fault).accepted, 1);
    be_held_in_crouch(c);
    ASSERT_TRUE(c.run_until(SupervisorState::idle, 10));
    c.ticks(wait);
    const Jerk again = arm_and_look(c);
    EXPECT_TRUE(again.accepted) << again.reason;
    expect_calm(again);
  }
}

/// The legs were moved by hand since the goals were set: with a packet lost they would run back.
TEST(ArmingGate, AnyPacketOfTheSequenceMayBeLostOrDamaged) {
  const model::Input elsewhere = 0.3 * crouch_pose();
  for (const auto spoil : {RobotPort::Spoil::lose_request, RobotPort::Spoil::damage_request,
                           RobotPort::Spoil::lose_reply, RobotPort::Spoil::damage_reply}) {
    EmulatedController c("nominal");
    be_held_in_crouch(c);
    ASSERT_TRUE(c.run_until(SupervisorState::idle, 10));
    for (int packet = 1; packet <= 24; ++packet) {
      SCOPED_TRACE(static_cast<int>(spoil) * 100 + packet);
      c.ticks(5);
      c.port.spoil = spoil;
      c.port.spoil_at = c.port.writes + packet;
      expect_calm(arm_and_look(c));
      c.port.spoil = RobotPort::Spoil::nothing;
      c.handover->emergency_stop = true;
      c.ticks(20);
      ASSERT_EQ(c.command(CommandKind::clear_fault).accepted, 1);
      std::array<double, 12> legs{};
      const model::Input pose = packet % 2 == 0 ? crouch_pose() : elsewhere;
      std::copy_n(pose.data(), 12, legs.begin());
      c.robot.place(emulator::with_legs(legs));
      c.robot.hold(true);
      ASSERT_TRUE(c.run_until(SupervisorState::idle, 10)) << name_of(c.controller->fault());
    }
  }
}

TEST(ArmingGate, RefusesWithANumberWhatItCannotKnow) {
  {
    EmulatedController c("nominal");
    be_held_in_crouch(c);
    ASSERT_TRUE(c.run_until(SupervisorState::idle, 10));
    c.handover->arming_allowed = false;
    EXPECT_EQ(c.command(CommandKind::arm).reason, static_cast<int>(Refusal::no_realtime));
  }
  {
    EmulatedController c("nominal");
    be_held_in_crouch(c);
    ASSERT_TRUE(c.run_until(SupervisorState::idle, 10));
    c.ticks(40);
    switch_fault(c, FaultKind::servo_silent, 2);  // a shoulder
    EXPECT_EQ(c.command(CommandKind::arm).reason, static_cast<int>(Refusal::servo_not_fresh));
    EXPECT_FALSE(c.controller->torque_on());
  }
  {
    EmulatedController c("nominal");
    be_held_in_crouch(c);
    ASSERT_TRUE(c.run_until(SupervisorState::idle, 10));
    switch_fault(c, FaultKind::servo_hot, 13, 1e3, 68);
    c.ticks(200);
    EXPECT_EQ(c.command(CommandKind::arm).reason, static_cast<int>(Refusal::hot_or_low));
  }
}

/// A person lifts the robot that has been lowered, or a session puts it back for the next trial.
TEST(ArmingGate, ARobotPutElsewhereWithoutTorqueIsNeitherAFaultNorLost) {
  EmulatedController c("nominal");
  be_held_in_crouch(c);
  ASSERT_TRUE(c.run_until(SupervisorState::idle, 10));
  c.robot.place(emulator::with_legs({}));  // straight legs
  c.robot.hold(true);
  c.ticks(30);
  EXPECT_EQ(c.controller->fault(), Fault::none);
  EXPECT_LT((model::joints(c.seen().x) - model::joints(c.truth())).cwiseAbs().maxCoeff(), 0.05);
  const Jerk jerk = arm_and_look(c);
  EXPECT_TRUE(jerk.accepted) << jerk.reason;
  expect_calm(jerk);
}

/// A servo whose supply of replies is fine and which yet will not take torque.
TEST(ArmingGate, AServoThatShutsDownEndsTheArmingWithTorqueOffEverywhere) {
  EmulatedController c("nominal");
  be_held_in_crouch(c);
  ASSERT_TRUE(c.run_until(SupervisorState::idle, 10));
  c.ticks(10);
  switch_fault(c, FaultKind::servo_overload, 4, 0.3);
  const Jerk jerk = arm_and_look(c);
  EXPECT_FALSE(jerk.accepted);
  expect_calm(jerk);
  EXPECT_EQ(torque_sum(c), 0.0);
}

TEST(ArmingGate, ArmsAndHeadComeFromFarAwayNoFasterThanLegs) {
  EmulatedController c("nominal");
  std::array<double, 12> legs{};
  std::copy_n(testing::standing_pose().data(), 12, legs.begin());
  emulator::Placement far = emulator::with_legs(legs);
  far.q[0] = 2.6;
  far.q[1] = -2.6;
  far.q[18] = 1.5;
  c.robot.place(far);
  c.robot.hold(true);
  c.upload(testing::still_primitives(testing::standing_pose(), 3.0));
  ASSERT_TRUE(c.run_until(SupervisorState::idle, 10));
  ASSERT_EQ(c.command(CommandKind::arm).accepted, 1);
  double fastest = 0;
  for (int i = 0; i < 900 && c.controller->state() != SupervisorState::hold; ++i) {
    c.tick();
    for (const double dq : c.robot.truth().dq) fastest = std::max(fastest, std::abs(dq));
  }
  EXPECT_EQ(c.controller->state(), SupervisorState::hold);
  EXPECT_LT(fastest, kMaxSpeed_rad_s);
  EXPECT_NEAR(c.robot.truth().q[0], kHeldServos[0].pose_rad, 0.1);
}

TEST(ArmingGate, AJointOutsideItsRangeIsBroughtInSlowly) {
  EmulatedController c("nominal");
  std::array<double, 12> legs{};
  std::copy_n(testing::standing_pose().data(), 12, legs.begin());
  legs[0] = model::kJoints[0].upper_rad + 0.4;
  c.robot.place(emulator::with_legs(legs));
  c.robot.hold(true);
  c.upload(testing::still_primitives(testing::standing_pose(), 3.0));
  ASSERT_TRUE(c.run_until(SupervisorState::idle, 10));
  const Jerk jerk = arm_and_look(c);
  EXPECT_TRUE(jerk.accepted) << jerk.reason;
  expect_calm(jerk);
}

}  // namespace
}  // namespace sanso::firmware
