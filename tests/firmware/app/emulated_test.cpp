// The whole controller on the emulated robot: standing up, a trial, lowering; a host that falls
// silent; every fault switch with the fault or limit that it must raise.
#include <gtest/gtest.h>

#include "tests/firmware/support/emulated_controller.h"

namespace sanso::firmware {
namespace {

using emulator::FaultKind;
using testing::EmulatedController;
using wire::CommandKind;
using wire::SupervisorState;

double tilt_of(const model::State& x) {
  return std::acos(math::rotation_matrix(model::base_quat(x))(2, 2));
}

TEST(EmulatedController, StandsUpRunsATrialStopsAndLowers) {
  for (const char* world : {"nominal", "lab"}) {
    SCOPED_TRACE(world);
    EmulatedController c(world);
    ASSERT_TRUE(c.stand());
    c.ticks(100);
    // three witnesses: the controller's belief, what it sends, the physics
    EXPECT_NEAR(c.seen().x[model::kXJoint + 3], testing::standing_pose()[3], 0.15);
    EXPECT_NEAR(c.seen().u_out[3], testing::standing_pose()[3], 0.02);
    EXPECT_NEAR(c.truth()[model::kXJoint + 3], c.seen().x[model::kXJoint + 3], 0.02);
    EXPECT_LT(tilt_of(c.truth()), 0.25);

    EXPECT_EQ(c.command(CommandKind::start_trial, 1, 150,
                        policy::LayerSwitches::kLower | policy::LayerSwitches::kReflex)
                  .accepted,
              1);
    EXPECT_EQ(c.seen().trial_tick, 0);
    c.ticks(149);
    EXPECT_EQ(c.seen().trial_tick, 149);
    c.tick();
    EXPECT_EQ(c.controller->state(), SupervisorState::soft_stop) << "the trial ends by itself";
    EXPECT_TRUE(c.run_until(SupervisorState::hold, 3));
    EXPECT_EQ(c.command(CommandKind::disarm).accepted, 1);
    EXPECT_TRUE(c.run_until(SupervisorState::idle, 6));
    EXPECT_LT(c.truth()[2], 0.19) << "lowered before the torque went";
    EXPECT_EQ(c.seen().fault, 0);
    EXPECT_EQ(c.seen().bus_lost, 0u);
  }
}

TEST(EmulatedController, CommandsThatDoNotFitAreRefusedWithTheirNumber) {
  EmulatedController c;
  ASSERT_TRUE(c.run_until(SupervisorState::idle, 10));
  c.ticks(3);
  EXPECT_EQ(c.command(CommandKind::arm).reason, static_cast<int>(Refusal::no_primitives));
  EXPECT_EQ(c.command(CommandKind::start_trial).reason, static_cast<int>(Refusal::wrong_state));
  EXPECT_EQ(c.command(CommandKind::clear_fault).reason, static_cast<int>(Refusal::wrong_state));
  EXPECT_EQ(c.command(CommandKind::none).accepted, 1);
}

TEST(EmulatedController, ASilentHostEndsTheTrialInHoldOnItsFeet) {
  EmulatedController c("lab");
  ASSERT_TRUE(c.stand());
  c.command(CommandKind::start_trial, 1, 1000, policy::LayerSwitches::kLower);
  c.ticks(100);
  c.host_alive = false;
  c.ticks(24);
  EXPECT_EQ(c.controller->state(), SupervisorState::run);
  EXPECT_TRUE(c.run_until(SupervisorState::soft_stop, 0.1));
  EXPECT_TRUE(c.run_until(SupervisorState::hold, 3));
  c.ticks(200);
  EXPECT_EQ(c.controller->state(), SupervisorState::hold);
  EXPECT_LT(tilt_of(c.truth()), 0.3);
}

// --- fault switches ------------------------------------------------------------------------------

struct FaultCase {
  const char* name;
  FaultKind kind;
  int id;
  double amount;
  Fault expected;
  double within_s;
};

class FaultSwitch : public ::testing::TestWithParam<FaultCase> {};

TEST_P(FaultSwitch, RaisesItsFault) {
  const FaultCase& fault = GetParam();
  EmulatedController c("nominal");
  ASSERT_TRUE(c.stand());
  c.ticks(200);
  emulator::Fault switched;
  switched.kind = fault.kind;
  switched.id = fault.id;
  switched.amount = fault.amount;
  switched.start = c.robot.now();
  c.robot.faults().add(switched);
  EXPECT_TRUE(c.run_until(SupervisorState::fault, fault.within_s));
  EXPECT_EQ(c.controller->fault(), fault.expected) << name_of(c.controller->fault());
  if (fault.id != 0) {
    EXPECT_EQ(c.controller->fault_detail(), fault.id);
  }
  const Fault latched = c.controller->fault();
  c.robot.faults().clear();
  c.ticks(20);
  EXPECT_EQ(c.controller->fault(), latched) << "a fault latches";
}

INSTANTIATE_TEST_SUITE_P(
    Each, FaultSwitch,
    ::testing::Values(
        FaultCase{"bus_drop", FaultKind::bus_drop, 0, 0, Fault::bus_silent, 0.2},
        FaultCase{"servo_silent", FaultKind::servo_silent, 14, 0, Fault::servo_silent, 0.5},
        FaultCase{"servo_overload", FaultKind::servo_overload, 13, 0, Fault::overload, 1.5},
        FaultCase{"servo_hot", FaultKind::servo_hot, 13, 0, Fault::over_temperature, 1.5},
        FaultCase{"imu_silent", FaultKind::imu_silent, 0, 0, Fault::imu_silent, 0.1},
        FaultCase{"imu_frozen", FaultKind::imu_frozen, 0, 0, Fault::imu_frozen, 0.2},
        FaultCase{"sagging_supply", FaultKind::brown_out, 0, 9.0, Fault::under_voltage, 1.5}),
    [](const auto& p) { return std::string(p.param.name); });

TEST(FaultSwitch, ABrownOutIsFoundWhateverShowsFirst) {
  EmulatedController c("nominal");
  ASSERT_TRUE(c.stand());
  emulator::Fault brown_out;
  brown_out.kind = FaultKind::brown_out;
  brown_out.start = c.robot.now();
  brown_out.stop = brown_out.start + 100 * kMillisecond;
  c.robot.faults().add(brown_out);
  ASSERT_TRUE(c.run_until(SupervisorState::fault, 4));
  const Fault f = c.controller->fault();
  EXPECT_TRUE(f == Fault::bus_silent || f == Fault::torque_lost || f == Fault::under_voltage ||
              f == Fault::fallen)
      << name_of(f);
}

TEST(FaultSwitch, DisturbedRepliesInformAndTheRobotCarriesOn) {
  for (const FaultKind kind :
       {FaultKind::bus_drop, FaultKind::bus_corrupt, FaultKind::bus_truncate, FaultKind::bus_delay,
        FaultKind::bus_duplicate, FaultKind::bus_garbage}) {
    SCOPED_TRACE(emulator::to_string(kind));
    EmulatedController c("nominal");
    ASSERT_TRUE(c.stand());
    emulator::Fault fault;
    fault.kind = kind;
    fault.probability = 0.02;
    fault.start = c.robot.now();
    c.robot.faults().add(fault);
    bool informed = false;
    for (int k = 0; k < 300; ++k) {
      c.tick();
      informed =
          informed || (c.seen().limits & (1u << static_cast<unsigned>(Limit::bus_loss))) != 0;
    }
    EXPECT_EQ(c.controller->state(), SupervisorState::hold) << name_of(c.controller->fault());
    if (kind == FaultKind::bus_drop || kind == FaultKind::bus_corrupt ||
        kind == FaultKind::bus_truncate) {
      EXPECT_TRUE(informed);
      EXPECT_GT(c.seen().bus_lost, 0u);
    }
  }
}

TEST(FaultSwitch, APulledCableLatchesAndTheServosHoldTheirLastGoal) {
  EmulatedController c("nominal");
  ASSERT_TRUE(c.stand());
  c.ticks(100);
  c.port.pulled = true;
  c.tick();
  EXPECT_EQ(c.controller->fault(), Fault::bus_gone);
  c.ticks(200);
  EXPECT_LT(tilt_of(c.truth()), 0.25) << "torque stays on: it stands";
  c.port.pulled = false;
  EXPECT_EQ(c.command(CommandKind::clear_fault).reason, static_cast<int>(Refusal::torque_on))
      << "it stands: clearing must not throw it down";
  EXPECT_EQ(c.command(CommandKind::lower).accepted, 1);
  for (int i = 0; i < 400 && c.controller->torque_on(); ++i) c.tick();
  EXPECT_LT(c.truth()[2], 0.19) << "lowered before the torque goes";
  EXPECT_LT(tilt_of(c.truth()), 0.5);
  EXPECT_EQ(c.command(CommandKind::clear_fault).accepted, 1);
  EXPECT_TRUE(c.run_until(SupervisorState::idle, 15)) << name_of(c.controller->fault());
}

TEST(FaultSwitch, APushedOverRobotGoesLimp) {
  EmulatedController c("nominal");
  ASSERT_TRUE(c.stand());
  c.ticks(100);
  const Nanoseconds now = c.robot.now();
  c.robot.push({40.0, 0, 0}, {0, 0, 0}, now, now + 200 * kMillisecond);
  ASSERT_TRUE(c.run_until(SupervisorState::fault, 3));
  EXPECT_EQ(c.controller->fault(), Fault::fallen);
  c.ticks(30);
  for (const double torque : c.robot.truth().torque) EXPECT_NEAR(torque, 0.0, 1e-9);
}

TEST(EmulatedController, TheSameSeedGivesTheSameBits) {
  const auto run = [] {
    EmulatedController c("lab");
    EXPECT_TRUE(c.stand());
    c.command(CommandKind::start_trial, 1, 100);
    c.ticks(90);
    return c.seen();
  };
  const wire::Observation a = run(), b = run();
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.u_out, b.u_out);
  EXPECT_EQ(a.imu_acc, b.imu_acc);
}

}  // namespace
}  // namespace sanso::firmware
