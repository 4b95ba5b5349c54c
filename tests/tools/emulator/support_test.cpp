// Laws of the hand that holds the torso, and what it does for a robot on wheels.
#include "tools/emulator/support.h"

#include <gtest/gtest.h>

#include "tests/tools/emulator/master.h"
#include "tools/plant/world.h"

namespace sanso::emulator {
namespace {

Support hand(double strength) {
  Support s;
  s.strength = strength;
  s.stiffness_N_m = {100.0, 300.0, 0.0};
  s.damping_Ns_m = {10.0, 30.0, 0.0};
  return s;
}

TEST(Support, IsASpringAndDamperInTheCarriagesAxes) {
  plant::BaseMotion base;
  base.p_world_base = {0.02, -0.01, 5.0};
  base.v_base_in_world = {0.1, 0.2, -3.0};
  const auto level = wrench_of(hand(1.0), base).force_in_world;
  EXPECT_NEAR(level[0], -100.0 * 0.02 - 10.0 * 0.1, 1e-12);
  EXPECT_NEAR(level[1], 300.0 * 0.01 - 30.0 * 0.2, 1e-12);
  EXPECT_EQ(level[2], 0.0);
  Support turned = hand(0.5);
  turned.quat_world_carriage = plant::from_rotation_vector({0, 0, plant::kPi / 2});
  base.quat_world_base = turned.quat_world_carriage;
  const auto half = wrench_of(turned, base).force_in_world;  // its left is -x of the world
  EXPECT_NEAR(half[0], 0.5 * (-300.0 * 0.02 - 30.0 * 0.1), 1e-12);
  EXPECT_NEAR(half[1], 0.5 * (100.0 * 0.01 - 10.0 * 0.2), 1e-12);
}

TEST(Support, TurnsTheTorsoBackAboutTheAxisThatItLeansOn) {
  plant::BaseMotion base;
  base.quat_world_base = plant::from_rotation_vector({0.0, 0.2, 0.0});
  base.w_base_in_base = {0.0, 0.5, 0.0};
  const auto torque = wrench_of(hand(1.0), base).torque_in_world;
  EXPECT_NEAR(torque[0], 0.0, 1e-12);
  EXPECT_NEAR(torque[1], -5.0 * 0.2 - 0.3 * 0.5, 1e-9);
  EXPECT_NEAR(torque[2], 0.0, 1e-12);
}

TEST(Support, IsNoStrongerThanAHand) {
  plant::BaseMotion base;
  base.p_world_base = {3.0, 4.0, 0.0};
  base.quat_world_base = plant::from_rotation_vector({2.0, 0.0, 0.0});
  const SupportWrench w = wrench_of(hand(0.5), base);
  EXPECT_NEAR(plant::norm(w.force_in_world), 0.5 * 15.0, 1e-9);
  EXPECT_NEAR(plant::norm(w.torque_in_world), 0.5 * 3.0, 1e-9);
}

/// The robot on wheels in its standing pose, on a level floor; tipped forward with 1 N m for 0.25 s
/// after it was let go. The hand holds up to 1.5 N m, not 2.
Truth pushed(const Support* support) {
  EmulatedRobot robot(plant::load_world("lab+plane+wheels"), 1);
  Master master(robot);
  master.stand_by();
  if (support) {
    Support there = *support;
    there.p_world_carriage = robot.truth().p_world_base;
    robot.support(there);
  }
  robot.hold(false);
  const Nanoseconds from = robot.now() + 500 * kMillisecond;
  robot.push({0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, from, from + 250 * kMillisecond);
  robot.advance(robot.now() + 2000 * kMillisecond);
  return robot.truth();
}

TEST(Support, OfNoStrengthChangesNotABit) {
  const Support nobody = hand(0.0);
  const Truth with = pushed(&nobody), without = pushed(nullptr);
  EXPECT_EQ(with.p_world_base, without.p_world_base);
  EXPECT_EQ(with.quat_world_base, without.quat_world_base);
  EXPECT_EQ(with.dq, without.dq);
}

TEST(Support, KeepsARobotOnWheelsUpThatFallsWithoutIt) {
  const Support there = hand(1.0);
  const Truth with = pushed(&there), without = pushed(nullptr);
  EXPECT_GT(without.other_contacts, 0);
  EXPECT_EQ(with.other_contacts, 0);
  const double up = plant::rotate(with.quat_world_base, {0.0, 0.0, 1.0})[2];  // cosine of the lean
  EXPECT_GT(up, 0.94);
}

}  // namespace
}  // namespace sanso::emulator
