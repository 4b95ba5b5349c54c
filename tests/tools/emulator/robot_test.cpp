// The whole emulated robot: it stands, it can be pushed, put back, and repeats itself to the bit.
#include <gtest/gtest.h>

#include "tests/tools/emulator/master.h"

namespace sanso::emulator {
namespace {

void let_stand(EmulatedRobot& robot) {
  Master master(robot);
  master.stand_by();
  robot.advance(robot.now() + 2 * kSecond);
}

double tilt(const Truth& t) { return 2 * std::acos(std::min(1.0, std::abs(t.quat_world_base[0]))); }

TEST(EmulatedRobot, StandsInEveryWorldWithoutHelp) {
  for (const char* name : {"nominal", "lab", "hard", "seed:1", "seed:2", "seed:3"}) {
    SCOPED_TRACE(name);
    EmulatedRobot robot(plant::load_world(name), 1);
    let_stand(robot);
    EXPECT_FALSE(robot.held());
    robot.advance(robot.now() + 3 * kSecond);
    const Truth t = robot.truth();
    EXPECT_NEAR(t.p_world_base[2], 0.245, 0.02);
    EXPECT_EQ(t.other_contacts, 0);
    const double weight = t.foot_force_in_world[0][2] + t.foot_force_in_world[1][2];
    EXPECT_GT(weight, 29.0);
    EXPECT_LT(weight, 37.0);
  }
}

TEST(EmulatedRobot, HeatAndChargeOutliveARobot) {
  EmulatedRobot first(plant::load_world("tired"), 1);
  let_stand(first);
  const plant::Condition after = first.condition();
  EXPECT_GT(after.used_Ah, 1e-5);
  EXPECT_LT(after.used_Ah, 1e-2);

  plant::Condition tired = after;
  tired.temperature_C.fill(70.0);
  tired.used_Ah = 1.5;
  EmulatedRobot next(plant::load_world("tired"), 1);
  next.begin_rested(tired);
  const plant::Condition rested = next.condition();
  EXPECT_LT(rested.temperature_C[12], 69.0) << "it cools between trials";
  EXPECT_GT(rested.temperature_C[12], 60.0) << "not in twenty seconds";
  EXPECT_EQ(rested.used_Ah, 1.5) << "a battery does not rest";
  EXPECT_NEAR(next.truth().supply_V, 12.4 - 2.2 * 1.5 / 1.8, 0.05);

  // weaker copper, less voltage: the same targets carry the robot less high
  let_stand(next);
  EXPECT_LT(next.truth().p_world_base[2], first.truth().p_world_base[2] - 0.0003);
}

TEST(EmulatedRobot, WithoutHeatInItsWorldNothingChanges) {
  plant::Condition tired;
  tired.temperature_C.fill(60.0);
  tired.used_Ah = 1.0;
  EmulatedRobot cold(plant::load_world("lab"), 1), warm(plant::load_world("lab"), 1);
  warm.begin_rested(tired);
  let_stand(cold);
  let_stand(warm);
  EXPECT_EQ(cold.truth().q, warm.truth().q);
}

TEST(EmulatedRobot, LimpRobotStaysInTheHandsThatHoldIt) {
  EmulatedRobot robot(plant::load_world("lab"), 1);
  robot.advance(2 * kSecond);
  EXPECT_TRUE(robot.held());
  EXPECT_NEAR(robot.truth().p_world_base[2], 0.247, 0.003);
}

TEST(EmulatedRobot, FallsWhenLetGoLimp) {
  EmulatedRobot robot(plant::load_world("lab"), 1);
  robot.hold(false);
  robot.advance(3 * kSecond);
  EXPECT_LT(robot.truth().p_world_base[2], 0.2);
  EXPECT_GT(robot.truth().other_contacts, 0);
}

TEST(EmulatedRobot, SmallPushIsSurvivedLargePushIsNot) {
  for (const auto& [force, falls] : {std::pair{4.0, false}, {60.0, true}}) {
    EmulatedRobot robot(plant::load_world("nominal"), 1);
    let_stand(robot);
    robot.push({0, force, 0}, {0, 0, 0}, robot.now(), robot.now() + 100 * kMillisecond);
    robot.advance(robot.now() + 3 * kSecond);
    EXPECT_EQ(tilt(robot.truth()) > 0.7, falls) << force << " N";
  }
}

TEST(EmulatedRobot, IsPutBackOnItsFeet) {
  EmulatedRobot robot(plant::load_world("lab"), 1);
  let_stand(robot);
  robot.push({50, 0, 0}, {0, 0, 0}, robot.now(), robot.now() + 200 * kMillisecond);
  robot.advance(robot.now() + 2 * kSecond);
  ASSERT_GT(tilt(robot.truth()), 0.7);
  Placement p = walkready();
  p.x_m = 0.3;
  p.yaw_rad = 0.5;
  robot.place(p);
  robot.advance(robot.now() + 2 * kSecond);
  const Truth t = robot.truth();
  EXPECT_NEAR(t.p_world_base[0], 0.3, 0.02);
  EXPECT_NEAR(t.p_world_base[2], 0.245, 0.02);
  EXPECT_NEAR(2 * std::atan2(t.quat_world_base[3], t.quat_world_base[0]), 0.5, 0.05);
}

TEST(EmulatedRobot, SameCallsSameBits) {
  const auto run = [] {
    EmulatedRobot robot(plant::load_world("lab"), 7);
    let_stand(robot);
    robot.push({10, 5, 0}, {0, 0, 0}, robot.now(), robot.now() + 100 * kMillisecond);
    robot.advance(robot.now() + kSecond);
    return robot.truth();
  };
  const Truth a = run(), b = run();
  EXPECT_EQ(a.leg_state(), b.leg_state());
  EXPECT_EQ(a.torque, b.torque);
}

TEST(EmulatedRobot, ManyServosUnderLoadPullTheSupplyDown) {
  EmulatedRobot robot(plant::load_world("hard"), 1);
  Master master(robot);
  master.stand_by(800);
  robot.advance(robot.now() + 200 * kMillisecond);
  EXPECT_NEAR(robot.truth().supply_V, 12.0, 0.3);
  std::vector<std::int64_t> goals(20, 2048);
  goals[10] = 2700, goals[11] = 1400, goals[12] = 1000, goals[13] = 3000;
  master.write_all(xm::kGoalPosition, goals);
  double lowest = 12;
  for (int ms = 0; ms < 200; ++ms) {
    robot.advance(robot.now() + kMillisecond);
    lowest = std::min(lowest, robot.truth().supply_V);
  }
  EXPECT_LT(lowest, 11.5);
}

TEST(EmulatedRobot, ResetButtonCutsTheServosPower) {
  EmulatedRobot robot(plant::load_world("nominal"), 1);
  let_stand(robot);
  robot.press(servo_bus::opencr::kButtonReset);
  robot.advance(robot.now() + 10 * kMillisecond);
  Master master(robot);
  servo_bus::PacketBuffer wire;
  servo_bus::encode_ping(wire, 7);
  EXPECT_FALSE(master.one(wire));
}

TEST(EmulatedRobot, LegStateListsTheRightLegFirst) {
  Truth t;
  for (int i = 0; i < kNumServos; ++i) t.q[i] = i + 1;
  const auto x = t.leg_state();
  EXPECT_EQ(x[7], 7);    // r_hip_yaw, id 7
  EXPECT_EQ(x[10], 13);  // r_knee
  EXPECT_EQ(x[13], 8);   // l_hip_yaw
  EXPECT_EQ(x[18], 18);  // l_ank_roll
}

}  // namespace
}  // namespace sanso::emulator
