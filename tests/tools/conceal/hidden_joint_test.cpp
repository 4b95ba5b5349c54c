// The hidden joint's own laws: they have to be the physics that the case says they are.
#include "tools/conceal/hidden_joint.h"

#include <gtest/gtest.h>

#include <algorithm>
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

TEST(HiddenJoint, TheRecordsOwnEncoderMovesNothing) {
  Rig plain, other;
  other.joint.record_offset = 0.05;
  for (Rig* rig : {&plain, &other}) rig->run(1.0, 0.4);
  EXPECT_EQ(other.q, plain.q);
  EXPECT_EQ(recorded_angle(plain.joint, plain.q), encoder_angle(plain.joint, plain.q));
  EXPECT_NEAR(recorded_angle(other.joint, other.q), recorded_angle(plain.joint, plain.q) + 0.05,
              1e-12);
  other.joint.offset = 0.05;  // the servo goes by its own
  other.run(1.0, 0.4);
  EXPECT_NEAR(other.q, plain.q - 0.05, 3 * plain.joint.quantum);
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

constexpr FrictionLaw kLaws[] = {FrictionLaw::lugre, FrictionLaw::dahl, FrictionLaw::arctangent};

TEST(HiddenJoint, EveryFrictionLawSlidesAtItsLevelBothWays) {
  for (const FrictionLaw law : kLaws) {
    for (const double rate : {1.5, -1.5}) {
      JointTruth j;
      j.formulas.friction = law;
      j.coulomb = 0.12;
      j.viscous = 0;
      JointMemory m;
      double torque = 0;
      for (int k = 0; k < 2000; ++k) torque = run_gear(j, 0, false, 0, rate, 0, kStep, m);
      EXPECT_NEAR(torque, std::copysign(0.12, -rate), 0.01 * 0.12) << static_cast<int>(law);
    }
  }
}

TEST(HiddenJoint, OnlyTheArctangentCreepsUnderALoadThatTheOthersHold) {
  for (const FrictionLaw law : kLaws) {
    for (const double load : {0.045, 0.06}) {
      Rig rig;
      rig.joint.formulas.friction = law;
      rig.joint.coulomb = 0.05;
      rig.joint.viscous = 0;
      rig.joint.voltage = 0;
      rig.load = load;
      rig.run(1.0, 0.0);
      const bool slides = load > 0.05 || law == FrictionLaw::arctangent;
      EXPECT_EQ(rig.q > 0.01, slides) << static_cast<int>(law) << " at " << load;
    }
  }
}

TEST(HiddenJoint, DryFrictionNeverGivesEnergyOverACycle) {
  for (const FrictionLaw law : kLaws) {
    JointTruth j;
    j.formulas.friction = law;
    j.viscous = 0;
    JointMemory m;
    double lost = 0;
    for (int k = 0; k < 20000; ++k) {
      const double t = k * kStep, rate = 0.3 * std::cos(6.283185307 * t);
      lost -=
          run_gear(j, 0, false, 0.3 / 6.283185307 * std::sin(6.283185307 * t), rate, 0, kStep, m) *
          rate * kStep;
    }
    // four strokes a second of 0.3/(2 pi) rad at 0.05 N m, less what breakaway takes
    EXPECT_NEAR(lost, 0.05 * 4 * 4 * 0.3 / 6.283185307, 0.006) << static_cast<int>(law);
  }
}

TEST(HiddenJoint, RoundTeethLoseTheSameWidth) {
  Rig rig;
  rig.joint.backlash = 0.04;
  rig.joint.formulas.teeth = Teeth::hertzian;
  rig.load = 0.2;
  rig.run(2.0, 0.0);
  const double one_side = rig.memory.motor_angle - rig.q;
  rig.load = -0.2;
  rig.run(2.0, 0.0);
  EXPECT_NEAR(std::abs(one_side - (rig.memory.motor_angle - rig.q)), 0.04, 0.001);
}

TEST(HiddenJoint, APolledMailboxDelaysAsMuchOnAverageAndUnevenly) {
  for (const double delay : {0.002, 0.012, 0.03}) {
    JointTruth j;
    j.command_delay_s = delay;
    EXPECT_EQ(instant_of_command(j, 0.5), 0.5 - delay);
    j.formulas.mailbox = Mailbox::polled;
    double sum = 0, least = 1, most = 0;
    constexpr int kTimes = 20000;
    for (int k = 0; k < kTimes; ++k) {
      const double t = 1e-4 * (k + 0.5), age = t - instant_of_command(j, t);
      sum += age, least = std::min(least, age), most = std::max(most, age);
    }
    EXPECT_NEAR(sum / kTimes, delay, 0.01 * delay);
    EXPECT_NEAR(most - least, std::min(delay, 0.0073), 0.06 * delay);
    EXPECT_GE(least, 0.0);
  }
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
