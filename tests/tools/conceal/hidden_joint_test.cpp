// The hidden joint's own laws: they have to be the physics that the case says they are.
#include "tools/conceal/hidden_joint.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sanso::conceal {
namespace {

constexpr double kStep = 0.0002;

/// A joint with a link of some inertia, driven through goal or held by hand.
struct Rig {
  JointTruth joint;
  JointMemory memory;
  double q = 0, dq = 0, inertia = 0.01, load = 0;

  void run(double seconds, double goal) {
    for (long k = 0; k < std::lround(seconds / kStep); ++k) {
      if (k % 5 == 0) run_servo(joint, goal, true, q, 5 * kStep, memory);
      const double torque = run_gear(joint, joint.voltage, true, q, dq, load, kStep, memory);
      const double mass = inertia + (two_masses(joint) ? 0 : joint.armature);
      dq += kStep * (torque + load) / mass;
      q += kStep * dq;
    }
  }
};

TEST(HiddenJoint, HoldsALoadWithTheServosStiffness) {
  Rig rig;
  rig.joint.coulomb = 0.001;
  rig.load = -1.0;
  rig.run(4.0, 0.0);
  const double stiffness = 3.223 * 12 * 1.78 / 5.22;
  EXPECT_NEAR(rig.q, -1.0 / stiffness, 2 * rig.joint.quantum);
}

TEST(HiddenJoint, BristleHoldsBelowTheBreakawayAndSlidesAbove) {
  for (const auto& [torque, moves] : {std::pair{0.045, false}, {0.06, true}}) {
    JointTruth j;
    j.coulomb = 0.05;
    j.viscous = 0;
    JointMemory m;
    double q = 0, dq = 0;
    for (int k = 0; k < 5000; ++k) {
      dq += kStep * (run_gear(j, 0, false, q, dq, 0, kStep, m) + torque) / 0.02;
      q += kStep * dq;
    }
    EXPECT_EQ(q > 0.01, moves) << torque;
  }
}

TEST(HiddenJoint, PlayLosesItsWidth) {
  Rig rig;
  rig.joint.backlash = 0.04;
  rig.load = 0.2;  // the link leans on one flank
  rig.run(2.0, 0.0);
  const double one_side = rig.memory.motor_angle - rig.q;
  rig.load = -0.2;
  rig.run(2.0, 0.0);
  const double other_side = rig.memory.motor_angle - rig.q;
  EXPECT_NEAR(std::abs(one_side - other_side), 0.04, 0.001);
}

TEST(HiddenJoint, DeadZoneEatsSmallErrors) {
  JointTruth j;
  j.dead_zone = 0.02;
  JointMemory m;
  run_servo(j, 4 * j.quantum, true, 0.0, 0.001, m);
  EXPECT_EQ(m.duty, 0.0);  // 3.223 x 0.0061 is below 0.02
  run_servo(j, 40 * j.quantum, true, 0.0, 0.001, m);
  EXPECT_NEAR(m.duty, 3.223 * 40 * j.quantum - 0.02, 1.0 / 885);
}

TEST(HiddenJoint, ProfileLimitsSpeed) {
  JointTruth j;
  j.profile_speed = 0.5;
  JointMemory m;
  run_servo(j, 0.0, true, 0.0, 0.001, m);
  for (int k = 0; k < 1000; ++k) run_servo(j, 2.0, true, 0.0, 0.001, m);
  EXPECT_NEAR(m.profile, 0.5, 0.002);
}

}  // namespace
}  // namespace sanso::conceal
