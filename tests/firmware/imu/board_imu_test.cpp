// OpenCR's IMU over the bus against what the physics does: the robot is pushed over and turned by
// hand, and the estimate from the board's registers has to agree with the truth.
#include "firmware/imu/board_imu.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shared/servo_bus/opencr.h"
#include "tests/firmware/support/emulated_controller.h"

namespace sanso::firmware {
namespace {

struct Rig {
  emulator::EmulatedRobot robot{plant::load_world("nominal"), 1};
  testing::RobotPort port{robot};
  testing::RobotClock clock{robot};
  BusMaster bus{BusSettings{}, port, clock};
  Mailbox<ImuSample> out;
  BoardImu imu{ImuSettings{}, out};

  void run(double seconds) {
    for (int i = 0; i < seconds * 100; ++i) {
      robot.advance(robot.now() + kTickPeriod);
      const Result<BoardReading> reading = bus.read_board();
      ASSERT_TRUE(reading.ok());
      imu.take(robot.now(), *reading);
    }
    out.update();
  }
  math::Vec3 true_up() const {
    const auto q = robot.truth().quat_world_base;
    return math::rotation_matrix(math::Quat(q[0], q[1], q[2], q[3])).row(2);
  }
  math::Vec3 seen_up() const { return math::rotation_matrix(out.front().quat_world_base).row(2); }
};

TEST(BoardImu, AtRestItShowsGravityAndTheTruthsTilt) {
  Rig rig;
  rig.run(2.0);
  EXPECT_NEAR(rig.out.front().accel.norm(), 9.81, 0.15);  // five times the noise
  EXPECT_LT(std::acos(std::min(1.0, rig.seen_up().dot(rig.true_up()))), 0.02);
}

TEST(BoardImu, AFallInAnyDirectionIsSeenInThatDirection) {
  for (const auto& force : {plant::Vec3{15, 0, 0}, plant::Vec3{-15, 0, 0}, plant::Vec3{0, 15, 0},
                            plant::Vec3{0, -15, 0}}) {
    Rig rig;
    rig.run(1.0);
    rig.robot.hold(false);
    rig.robot.push(force, {}, rig.robot.now(), rig.robot.now() + 300 * kMillisecond);
    rig.run(2.5);
    const math::Vec3 truth = rig.true_up();
    ASSERT_LT(truth[2], 0.8) << "it has tipped over";
    EXPECT_LT(std::acos(std::clamp(rig.seen_up().dot(truth), -1.0, 1.0)), 0.15)
        << "force " << force[0] << ", " << force[1] << ", truth " << truth.transpose() << ", seen "
        << rig.seen_up().transpose();
  }
}

TEST(BoardImu, ButtonsAndVoltageComeWithIt) {
  Rig rig;
  rig.robot.press(servo_bus::opencr::kButtonUser);
  const Result<BoardReading> reading = rig.bus.read_board();
  ASSERT_TRUE(reading.ok());
  EXPECT_EQ(reading->buttons, servo_bus::opencr::kButtonUser);
  rig.run(0.1);
  EXPECT_NEAR(rig.bus.read_board()->voltage_V, rig.robot.truth().supply_V, 0.1);
}

/// A robot with OpenCR's own IMU: its buttons mean something while it stands.
TEST(BoardImu, UserStopsAtOnceAndModeLowersOnceForEachPress) {
  Settings settings;
  settings.imu.from_board = true;
  for (const bool user : {true, false}) {
    SCOPED_TRACE(user);
    testing::EmulatedController c("nominal", settings);
    c.without_hid = true;
    ASSERT_TRUE(c.stand());
    c.robot.press(servo_bus::opencr::kButtonStart);
    c.ticks(5);
    EXPECT_EQ(c.controller->state(), wire::SupervisorState::hold) << "Start moves nothing";
    c.robot.press(user ? servo_bus::opencr::kButtonUser : servo_bus::opencr::kButtonMode);
    c.ticks(3);
    if (user) {
      EXPECT_EQ(c.controller->fault(), Fault::emergency_stop);
      continue;
    }
    EXPECT_EQ(c.controller->state(), wire::SupervisorState::soft_stop);
    EXPECT_TRUE(c.run_until(wire::SupervisorState::idle, 6));
    ASSERT_EQ(c.command(wire::CommandKind::arm).accepted, 1) << "held down it asks no more";
  }
}

}  // namespace
}  // namespace sanso::firmware
