// One step of a servo: limits, derivatives it promises, symmetry, profile, supply, heat.
#include "tools/diagnose/sim/actuator.h"

#include <gtest/gtest.h>

#include "tests/support/small_world.h"

namespace sanso::diagnose {
namespace {

using namespace test;

JointParams servo(const std::string& settings = "") {
  return make_params(pendulum("actuator = \"dc_servo\"\ntorque_limit = 0\n" + settings)).joints[0];
}
JointParams position(const std::string& settings = "kp = 20\nkd = 0.5\n") {
  return make_params(pendulum("actuator = \"position_pd\"\n" + settings)).joints[0];
}

/// A servo at `position` moving with `velocity`, asked for `goal`.
ServoInput input(double goal, double position = 0.0, double velocity = 0.0) {
  ServoInput in{};
  in.command = {goal, 0.0, false};
  in.h = 1e-3;
  in.position = position;
  in.velocity = in.motor_velocity = velocity;
  in.supply = 1.0;
  return in;
}

ServoOutput once(const JointParams& joint, const ServoInput& in) {
  InnerState inner;
  return servo_step(joint, in, inner);
}

TEST(Servo, TorqueIsTheMotorsEquation) {
  // duty = p e; i = (duty V - ke w) / R; tau = kt i
  const JointParams joint = servo("p_gain = 3\nvoltage = 10\nresistance = 4\nback_emf = 2\n");
  const ServoOutput out = once(joint, input(0.2, 0.05, 0.7));
  EXPECT_NEAR(out.duty, 3 * 0.15, 1e-12);
  EXPECT_NEAR(out.current, (0.45 * 10 - 2 * 0.7) / 4, 1e-12);
  EXPECT_NEAR(out.torque, 1.78 * out.current, 1e-12);
}

TEST(Servo, ItsDerivativesAreThoseOfItsTorque) {
  constexpr double kStep = 1e-6;
  JointParams filtered = servo("d_gain = 0.1\n");
  filtered.output_filter = 0.004;
  JointParams smooth = filtered;
  smooth.filters_rate = true;
  for (const JointParams& joint : {servo("d_gain = 0.1\n"), filtered, smooth, position()}) {
    const auto torque = [&](double q, double dq, double motor) {
      ServoInput in = input(0.1, q, dq);
      in.motor_velocity = motor;
      return once(joint, in).torque;
    };
    const ServoOutput out = once(joint, input(0.1));
    EXPECT_NEAR(out.stiffness, -(torque(kStep, 0, 0) - torque(-kStep, 0, 0)) / (2 * kStep), 1e-6);
    EXPECT_NEAR(out.damping, -(torque(0, kStep, 0) - torque(0, -kStep, 0)) / (2 * kStep), 1e-6);
    EXPECT_NEAR(out.back_emf_damping, -(torque(0, 0, kStep) - torque(0, 0, -kStep)) / (2 * kStep),
                1e-6);
  }
}

TEST(Servo, AtALimitNothingDependsOnThePositionAnyMore) {
  for (const JointParams& joint :
       {servo("duty_limit = 0.3\n"), position("kp = 20\ntorque_limit = 1\n")}) {
    const ServoOutput out = once(joint, input(5.0));
    EXPECT_EQ(out.stiffness, 0.0);
    EXPECT_EQ(out.torque, once(joint, input(6.0)).torque);
  }
}

TEST(Servo, KeepsEveryLimitInBothDirections) {
  for (const double goal : {-9.0, 9.0}) {
    EXPECT_NEAR(std::abs(once(servo("duty_limit = 0.4\n"), input(goal)).duty), 0.4, 1e-12);
    EXPECT_NEAR(std::abs(once(servo("current_limit = 0.7\n"), input(goal)).current), 0.7, 1e-12);
    JointParams limited = servo();
    limited.nominal.torque_limit = 0.9;
    EXPECT_NEAR(std::abs(once(limited, input(goal)).torque), 0.9, 1e-12);
    EXPECT_NEAR(std::abs(once(position("kp = 20\ntorque_limit = 2\n"), input(goal)).torque), 2.0,
                1e-12);
  }
}

TEST(Servo, IsOddWhateverIsSwitchedOn) {
  JointParams joint = servo("d_gain = 0.05\ncurrent_limit = 1.0\n");
  joint.dead_zone = 0.02, joint.output_filter = 0.01, joint.feed_forward = 0.1;
  joint.profile_speed = 2.0, joint.integral_rate = 1.0;
  InnerState right, left;
  for (int k = 0; k < 200; ++k) {
    ServoInput in = input(std::sin(0.05 * k), 0.3 * std::cos(0.03 * k), 0.4);
    in.command.rate = 0.2;
    ServoInput mirrored = in;
    mirrored.command.value *= -1, mirrored.command.rate *= -1, mirrored.position *= -1;
    mirrored.velocity *= -1, mirrored.motor_velocity *= -1;
    EXPECT_EQ(servo_step(joint, in, right).torque, -servo_step(joint, mirrored, left).torque) << k;
  }
}

TEST(Servo, InsideTheDeadZoneNothingIsAskedAndBeyondItThatMuchIsMissing) {
  JointParams joint = servo("p_gain = 1\n");
  joint.dead_zone = 0.1;
  EXPECT_EQ(once(joint, input(0.09)).duty, 0.0);
  EXPECT_NEAR(once(joint, input(0.25)).duty, 0.15, 1e-12);
  EXPECT_NEAR(once(joint, input(-0.25)).duty, -0.15, 1e-12);
}

TEST(Servo, AFilterLagsByItsTimeConstantAndThenIsNotThere) {
  JointParams joint = servo("p_gain = 1\n");
  joint.output_filter = 0.05;
  InnerState inner;
  double duty = 0.0;
  for (int k = 1; k <= 400; ++k) {
    duty = servo_step(joint, input(0.4), inner).duty;
    if (k == 50) {
      EXPECT_NEAR(duty, 0.4 * (1 - std::exp(-1.0)), 0.004);
    }
  }
  EXPECT_NEAR(duty, 0.4, 2e-4);
}

TEST(Servo, AFilterOfTheRateLeavesTheErrorAsItIs) {
  JointParams joint = servo("p_gain = 1\nd_gain = 0.1\n");
  joint.output_filter = 0.05;
  joint.filters_rate = true;
  EXPECT_NEAR(once(joint, input(0.4)).duty, 0.4, 1e-12);
  InnerState inner;
  double duty = 0.0;
  for (int k = 1; k <= 400; ++k) {
    duty = servo_step(joint, input(0.4, 0.0, 2.0), inner).duty;
    if (k == 50) {
      EXPECT_NEAR(duty, 0.4 - 0.2 * (1 - std::exp(-1.0)), 0.004);
    }
  }
  EXPECT_NEAR(duty, 0.4 - 0.2, 2e-4);
}

TEST(Servo, AProfileKeepsItsSpeedAndAccelerationAndArrivesWithoutOvershoot) {
  JointParams joint = servo("p_gain = 1\n");
  joint.profile_speed = 2.0, joint.profile_acceleration = 8.0;
  InnerState inner;
  double speed = 0.0, fastest = 0.0, farthest = 0.0;
  for (int k = 0; k < 1500; ++k) {
    servo_step(joint, input(1.0), inner);
    EXPECT_LE(std::abs(inner.profile_speed - speed), 8.0 * 1e-3 + 1e-12);
    speed = inner.profile_speed;
    fastest = std::max(fastest, speed);
    farthest = std::max(farthest, inner.profile);
  }
  EXPECT_NEAR(fastest, 2.0, 1e-9);
  EXPECT_NEAR(inner.profile, 1.0, 1e-3);
  EXPECT_LT(farthest, 1.01);
}

TEST(Servo, AnIntegralGrowsWithTheErrorsArea) {
  JointParams joint = servo("p_gain = 1\n");
  joint.integral_rate = 2.0;
  InnerState inner;
  double duty = 0.0;
  for (int k = 0; k < 1000; ++k) duty = servo_step(joint, input(0.1), inner).duty;
  EXPECT_NEAR(duty, 0.1 + 2.0 * 0.1 * 1.0, 1e-9);
}

TEST(Servo, FeedForwardAddsTheGoalsSpeed) {
  JointParams joint = servo("p_gain = 2\n");
  joint.feed_forward = 0.1;
  ServoInput in = input(0.0);
  in.command.rate = 0.5;
  EXPECT_NEAR(once(joint, in).duty, 2 * 0.1 * 0.5, 1e-12);
}

TEST(Servo, LessSupplyIsLessTorqueInProportionAtStandstill) {
  for (const double supply : {1.0, 0.8, 0.5}) {
    ServoInput in = input(0.1);
    in.supply = supply;
    EXPECT_NEAR(once(servo(), in).torque, supply * once(servo(), input(0.1)).torque, 1e-12);
    EXPECT_NEAR(once(servo(), in).volt, 12 * supply, 1e-12);
  }
}

TEST(Servo, ScalesOfTorqueResistanceAndGainActWhereTheyShould) {
  const double nominal = once(servo(), input(0.1)).torque;
  JointParams joint = servo();
  joint.torque_scale = 0.9;
  EXPECT_NEAR(once(joint, input(0.1)).torque, 0.9 * nominal, 1e-12);
  joint = servo(), joint.resistance_scale = 1.25;
  EXPECT_NEAR(once(joint, input(0.1)).torque, nominal / 1.25, 1e-12);
  joint = servo(), joint.p_scale = 1.5;
  EXPECT_NEAR(once(joint, input(0.1)).torque, 1.5 * nominal, 1e-12);
  joint = servo(), joint.d_torque = 0.3;
  EXPECT_NEAR(once(joint, input(0.1, 0, 0.2)).torque,
              once(servo(), input(0.1, 0, 0.2)).torque - 0.3 * 0.2, 1e-12);
}

TEST(Servo, WarmthTakesItsShare) {
  JointParams joint = servo();
  joint.derating = 0.004;
  ServoInput in = input(0.1);
  in.warming = 50.0;
  EXPECT_NEAR(once(joint, in).torque, 0.8 * once(servo(), input(0.1)).torque, 1e-12);
}

TEST(Servo, ATorqueSourceLosesItsLimitWithSpeed) {
  JointParams joint = make_params(pendulum("actuator = \"torque\"\ntorque_limit = 4\n")).joints[0];
  joint.no_load_speed = 10.0;
  for (const double speed : {0.0, 2.5, 5.0, 10.0}) {
    EXPECT_NEAR(once(joint, input(9.0, 0, speed)).torque, 4.0 * (1 - speed / 10), 1e-12);
    EXPECT_NEAR(once(joint, input(-9.0, 0, -speed)).torque, -4.0 * (1 - speed / 10), 1e-12);
    EXPECT_NEAR(once(joint, input(-9.0, 0, speed)).torque, -4.0 * (1 + speed / 10), 1e-12)
        << "braking";
  }
}

TEST(Servo, SwitchedOffForgetsEverythingAndGivesNothing) {
  JointParams joint = servo();
  joint.integral_rate = 3.0, joint.output_filter = 0.02, joint.profile_speed = 1.0;
  InnerState inner;
  for (int k = 0; k < 50; ++k) servo_step(joint, input(0.3), inner);
  ServoInput off = input(0.3, 0.0, 4.0);
  off.command.off = true;
  const ServoOutput out = servo_step(joint, off, inner);
  EXPECT_EQ(out.torque, 0.0);
  EXPECT_EQ(out.current, 0.0);
  EXPECT_EQ(out.back_emf_damping, 0.0);
  EXPECT_EQ(inner.integral, 0.0);
  EXPECT_EQ(inner.filtered, 0.0);
  EXPECT_FALSE(inner.profile_set);
}

TEST(Encoder, ReadingAndPositionAreInverseAndTheSlopeIsTheSlope) {
  JointParams joint;
  joint.encoder_offset = 0.07, joint.encoder_scale = -0.03;
  joint.encoder_error = {0.01, -0.02, 2.0};
  joint.gear_error = {0.003, 0.001, 5.0};
  joint.record_offset = -0.02;
  for (double q = -3.0; q <= 3.0; q += 0.25) {
    EXPECT_NEAR(position_for_reading(joint, encoder_reading(joint, q)), q, 1e-8);
    EXPECT_NEAR(encoder_slope(joint, q),
                (encoder_reading(joint, q + 1e-6) - encoder_reading(joint, q - 1e-6)) / 2e-6, 1e-8);
  }
}

TEST(Ripple, RepeatsWithItsOrderAndItsSlopeIsItsSlope) {
  const Ripple ripple{0.3, -0.2, 7.0};
  for (double x = -2.0; x < 2.0; x += 0.3) {
    EXPECT_NEAR(ripple_at(ripple, x), ripple_at(ripple, x + 2 * M_PI / 7), 1e-12);
    EXPECT_NEAR(ripple_slope(ripple, x),
                (ripple_at(ripple, x + 1e-6) - ripple_at(ripple, x - 1e-6)) / 2e-6, 1e-8);
  }
  EXPECT_EQ(ripple_at(Ripple{}, 1.0), 0.0);
}

}  // namespace
}  // namespace sanso::diagnose
