// The edges of a session on the emulated robot: starting, arming, leaving a fault, stopping. None
// of them may throw a standing robot down or make its limbs jump.
#include <gtest/gtest.h>

#include <functional>

#include "tests/firmware/support/edges.h"

namespace sanso::firmware {
namespace {

using emulator::FaultKind;
using testing::EmulatedController;
using testing::on_its_feet;
using testing::switch_fault;
using testing::torque_sum;
using wire::CommandKind;
using wire::SupervisorState;

/// Ticks until the torque goes; the robot is then low and has not fallen.
void expect_lowered(EmulatedController& c) {
  for (int i = 0; i < 800 && c.controller->torque_on(); ++i) c.tick();
  EXPECT_FALSE(c.controller->torque_on());
  EXPECT_LT(c.truth()[2], 0.19);
  EXPECT_EQ(c.robot.truth().other_contacts, 0);
  EXPECT_LT(std::acos(math::rotation_matrix(model::base_quat(c.truth()))(2, 2)), 0.5);
  c.ticks(2);
  EXPECT_EQ(torque_sum(c), 0.0);
}
void push_over(EmulatedController& c) {
  c.robot.push({40, 0, 0}, {0, 0, 0}, c.robot.now(), c.robot.now() + 400 * kMillisecond);
}

// --- start and stop ------------------------------------------------------------------------------

TEST(Restart, AdoptsAStandingRobotWithoutTakingItsTorque) {
  EmulatedController c("nominal");
  ASSERT_TRUE(c.stand());
  for (const int pause_ticks : {20, 500}) {
    c.robot.advance(c.robot.now() + pause_ticks * kTickPeriod);
    c.port.torque_off_writes = 0;
    const model::State before = c.truth();
    c.start();
    ASSERT_TRUE(c.run_until(SupervisorState::hold, 12)) << name_of(c.controller->fault());
    c.ticks(300);
    EXPECT_EQ(c.port.torque_off_writes, 0);
    EXPECT_TRUE(on_its_feet(c));
    EXPECT_LT((model::joints(c.truth()) - model::joints(before)).cwiseAbs().maxCoeff(), 0.05);
  }
  c.upload(testing::still_primitives(testing::standing_pose(), 3.0));
  c.ticks(200);
  EXPECT_EQ(c.command(CommandKind::start_trial, 2, 50, policy::LayerSwitches::kLower).accepted, 1)
      << "and goes on as if nothing had happened";
  c.ticks(300);
  EXPECT_EQ(c.command(CommandKind::lower).accepted, 1);
  expect_lowered(c);
}

TEST(Restart, InMidSquatAndInASoftStopLeavesTheRobotOnItsFeet) {
  model::Input low = testing::standing_pose();
  for (const int j : {2, 4, 8, 10}) low[j] *= 1.5;
  for (const int j : {3, 9}) low[j] *= 1.5;
  EmulatedController c("nominal");
  ASSERT_TRUE(c.stand());
  c.upload(testing::still_primitives(low, 3.0));
  c.ticks(60);  // on the way down
  c.robot.advance(c.robot.now() + kSecond);
  c.port.torque_off_writes = 0;
  c.start();
  ASSERT_TRUE(c.run_until(SupervisorState::hold, 12)) << name_of(c.controller->fault());
  EXPECT_EQ(c.command(CommandKind::lower).accepted, 1);
  c.ticks(50);
  c.start();
  ASSERT_TRUE(c.run_until(SupervisorState::hold, 12)) << name_of(c.controller->fault());
  c.ticks(200);
  EXPECT_EQ(c.port.torque_off_writes, 0);
  EXPECT_EQ(c.robot.truth().other_contacts, 0);
}

TEST(Restart, WithAServoThatDoesNotAnswerTheOthersKeepTheirTorque) {
  EmulatedController c("nominal");
  ASSERT_TRUE(c.stand());
  switch_fault(c, FaultKind::servo_silent, 5);  // an elbow: the robot stands on without it
  c.port.torque_off_writes = 0;
  c.start();
  ASSERT_TRUE(c.run_until(SupervisorState::fault, 12));
  EXPECT_EQ(c.controller->fault(), Fault::servo_missing);
  c.ticks(100);
  EXPECT_EQ(c.port.torque_off_writes, 0);
  EXPECT_TRUE(on_its_feet(c));
  EXPECT_EQ(c.command(CommandKind::clear_fault).reason, static_cast<int>(Refusal::torque_on));
  EXPECT_EQ(c.command(CommandKind::lower).accepted, 1);
  c.ticks(300);
  EXPECT_LT(c.truth()[2], 0.19);
  EXPECT_EQ(c.robot.truth().other_contacts, 0);
  c.ticks(100);
  EXPECT_FALSE(c.controller->torque_on()) << "the silent one is waited for no longer";
}

TEST(EndRequest, LowersTheRobotFromWhereverItIsAndOnlyThenMayTheProgramEnd) {
  for (const bool in_trial : {false, true}) {
    SCOPED_TRACE(in_trial);
    EmulatedController c("nominal");
    ASSERT_TRUE(c.stand());
    if (in_trial) {
      c.command(CommandKind::start_trial, 1, 1000, policy::LayerSwitches::kLower);
      c.ticks(50);
    }
    c.handover->end_requested = true;
    c.ticks(100);
    EXPECT_FALSE(c.handover->may_end);
    EXPECT_EQ(c.command(CommandKind::start_trial).accepted, 0);
    expect_lowered(c);
    EXPECT_TRUE(c.handover->may_end);
  }
}

TEST(EndRequest, WithoutTorqueTheProgramMayEndAtOnceAndCannotBeArmed) {
  EmulatedController c("nominal");
  c.upload(testing::still_primitives(testing::standing_pose(), 3.0));
  ASSERT_TRUE(c.run_until(SupervisorState::idle, 10));
  c.handover->end_requested = true;
  EXPECT_EQ(c.command(CommandKind::arm).reason, static_cast<int>(Refusal::ending));
  EXPECT_TRUE(c.handover->may_end);
}

TEST(LeftAlone, ARobotThatNoHostTalksToIsLoweredInEveryStateWithTorque) {
  for (const FaultKind kind : {FaultKind::pose_lost, FaultKind::servo_overload}) {
    Settings settings;
    settings.supervisor.left_alone_s = 2.0;
    EmulatedController c("nominal", settings);
    ASSERT_TRUE(c.stand());
    switch_fault(c, kind, 5);  // nothing in hold, then a fault that holds
    c.ticks(150);
    c.host_alive = false;
    c.ticks(150);
    EXPECT_GT(c.truth()[2], 0.2);
    expect_lowered(c);
  }
}

// --- faults --------------------------------------------------------------------------------------

TEST(InAFault, ARobotThatIsPushedOverGoesLimp) {
  EmulatedController c("nominal");
  ASSERT_TRUE(c.stand());
  switch_fault(c, FaultKind::servo_overload, 5);
  ASSERT_TRUE(c.run_until(SupervisorState::fault, 3));
  ASSERT_EQ(c.controller->fault(), Fault::overload);
  c.ticks(100);
  EXPECT_TRUE(on_its_feet(c));
  push_over(c);
  c.ticks(500);
  EXPECT_EQ(c.controller->fault(), Fault::overload) << "the first one stays";
  EXPECT_EQ(torque_sum(c), 0.0);
  EXPECT_EQ(c.command(CommandKind::clear_fault).accepted, 1) << "down and without torque";
}

TEST(InAFault, WithoutAnImuTheRobotIsLoweredByItself) {
  EmulatedController c("nominal");
  ASSERT_TRUE(c.stand());
  switch_fault(c, FaultKind::imu_silent);
  ASSERT_TRUE(c.run_until(SupervisorState::fault, 1));
  EXPECT_EQ(c.command(CommandKind::clear_fault).reason, static_cast<int>(Refusal::torque_on));
  expect_lowered(c);
  c.robot.faults().clear();
  EXPECT_EQ(c.command(CommandKind::clear_fault).accepted, 1);
  EXPECT_TRUE(c.run_until(SupervisorState::idle, 15)) << name_of(c.controller->fault());
}

TEST(InAFault, AKneeThatRebootsMakesItFallAndThenLimp) {
  EmulatedController c("nominal");
  ASSERT_TRUE(c.stand());
  servo_bus::PacketBuffer reboot;
  (void)servo_bus::encode_reboot(reboot, 13);
  c.robot.bus_write(reboot.view());
  c.ticks(700);
  EXPECT_EQ(c.controller->state(), SupervisorState::fault);
  EXPECT_EQ(torque_sum(c), 0.0);
}

TEST(EmergencyStop, TakesTheTorqueWithinTwoTicksFromAnywhereAndLatches) {
  const std::vector<std::function<void(EmulatedController&)>> ways = {
      [](EmulatedController& c) { c.handover->emergency_stop = true; },
      [](EmulatedController& c) {
        c.handover->commands.push({1'000'000, CommandKind::emergency_stop, 0, 0, 0});
      }};
  const std::vector<std::function<void(EmulatedController&)>> situations = {
      [](EmulatedController&) {},
      [](EmulatedController& c) {
        c.command(CommandKind::start_trial, 1, 500, policy::LayerSwitches::kLower);
        c.ticks(20);
      },
      [](EmulatedController& c) { c.command(CommandKind::lower); },
      [](EmulatedController& c) {
        switch_fault(c, FaultKind::servo_overload, 5);
        c.run_until(SupervisorState::fault, 3);
      }};
  for (const auto& press : ways)
    for (const auto& situation : situations) {
      EmulatedController c("nominal");
      ASSERT_TRUE(c.stand());
      situation(c);
      press(c);
      c.ticks(2);
      c.robot.advance(c.robot.now() + 2 * kMillisecond);
      EXPECT_EQ(torque_sum(c), 0.0);
      c.ticks(20);
      EXPECT_EQ(c.controller->fault(), Fault::emergency_stop);
      EXPECT_EQ(c.command(CommandKind::arm).accepted, 0);
    }
}

// --- wrong readings, other masters ---------------------------------------------------------------

/// Zeros with a right CRC, as some adapters make them: a knee at -3.14 rad.
TEST(WrongReadings, ZerosFromAnyLegServoMoveNothing) {
  EmulatedController c("nominal");
  ASSERT_TRUE(c.stand());
  for (const int id : {7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18})
    for (const int ticks : {1, 3, 5}) {
      switch_fault(c, FaultKind::reply_zeros, id, 0.01 * ticks);
      for (int k = 0; k < 30; ++k) {
        const model::Input before = c.seen().u_out;
        c.tick();
        ASSERT_LE((c.seen().u_out - before).cwiseAbs().maxCoeff(), 0.15);
      }
      ASSERT_EQ(c.controller->state(), SupervisorState::hold) << name_of(c.controller->fault());
      ASSERT_TRUE(on_its_feet(c));
    }
}

TEST(OtherMaster, IsFoundBeforeTheFirstRequestAndLater) {
  EmulatedController early("nominal");
  switch_fault(early, FaultKind::foreign_master, 0, 5.0);
  ASSERT_TRUE(early.run_until(SupervisorState::fault, 1.0));
  EXPECT_EQ(early.controller->fault(), Fault::bus_foreign);
  EXPECT_EQ(early.port.writes, 0) << "nothing is sent";

  EmulatedController later("nominal");
  ASSERT_TRUE(later.stand());
  switch_fault(later, FaultKind::foreign_master);
  ASSERT_TRUE(later.run_until(SupervisorState::fault, 1.0));
  EXPECT_EQ(later.controller->fault(), Fault::bus_foreign);
  later.ticks(100);
  EXPECT_TRUE(on_its_feet(later));
}

TEST(LostRequests, OfOnePercentCostNoFall) {
  for (const FaultKind kind : {FaultKind::request_drop, FaultKind::request_corrupt}) {
    EmulatedController c("nominal");
    ASSERT_TRUE(c.stand());
    emulator::Fault fault;
    fault.kind = kind;
    fault.probability = 0.01;
    fault.start = c.robot.now();
    c.robot.faults().add(fault);
    c.ticks(1000);
    EXPECT_EQ(c.controller->state(), SupervisorState::hold) << name_of(c.controller->fault());
    EXPECT_TRUE(on_its_feet(c));
  }
}

}  // namespace
}  // namespace sanso::firmware
