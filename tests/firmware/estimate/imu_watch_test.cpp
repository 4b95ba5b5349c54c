// An IMU that is mounted wrong, flips an axis, jumps or speaks in other units is found; a good one
// is believed through standing, leaning and a push.
#include "firmware/estimate/imu_watch.h"

#include <gtest/gtest.h>

#include "tests/firmware/support/emulated_controller.h"

namespace sanso::firmware {
namespace {

using testing::EmulatedController;
using wire::SupervisorState;

Settings mounted(const math::Quat& quat_base_sensor) {
  Settings s;
  s.imu.quat_base_sensor_w = quat_base_sensor[0];
  s.imu.quat_base_sensor_x = quat_base_sensor[1];
  s.imu.quat_base_sensor_y = quat_base_sensor[2];
  s.imu.quat_base_sensor_z = quat_base_sensor[3];
  return s;
}

/// The trunk leans forward and back by the hips.
model::Input leaning(double angle) {
  model::Input q = testing::standing_pose();
  q[2] += angle;
  q[8] -= angle;
  return q;
}

TEST(ImuWatch, BelievesAGoodSensorInMotion) {
  for (const char* world : {"nominal", "lab"}) {
    EmulatedController c(world);
    ASSERT_TRUE(c.stand());
    for (const double angle : {0.12, -0.05, 0.12, 0.0}) {
      c.upload(testing::still_primitives(leaning(angle), 3.0));
      c.ticks(60);
      EXPECT_EQ(c.controller->fault(), Fault::none) << world << c.controller->fault_detail();
    }
    c.robot.push({6, 0, 0}, {0, 0, 0}, c.robot.now(), c.robot.now() + 100 * kMillisecond);
    c.ticks(200);
    EXPECT_EQ(c.controller->fault(), Fault::none) << world << c.controller->fault_detail();
  }
}

/// The rotations that turn the axes of a box onto one another, but for the identity.
std::vector<math::Quat> wrong_right_angles() {
  std::vector<math::Quat> out;
  const auto add = [&](const math::Quat& q) {
    if (math::quat_minus(q, math::quat_identity()).norm() < 1e-6) return;
    for (const math::Quat& known : out)
      if (math::quat_minus(q, known).norm() < 1e-6) return;
    out.push_back(q);
  };
  constexpr double kQuarter = 0.5 * model::kPi;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b)
      for (int c = 0; c < 4; ++c)
        add(math::quat_multiply(math::quat_exp({0, 0, kQuarter * a}),
                                math::quat_multiply(math::quat_exp({0, kQuarter * b, 0}),
                                                    math::quat_exp({kQuarter * c, 0, 0}))));
  return out;
}

TEST(ImuWatch, EveryWrongRightAngleIsFoundBeforeItCanDoHarm) {
  const auto mountings = wrong_right_angles();
  ASSERT_EQ(mountings.size(), 23u);
  int refused = 0, found_in_motion = 0;
  for (const math::Quat& mounting : mountings) {
    SCOPED_TRACE(mounting.transpose());
    EmulatedController c("nominal", mounted(mounting), false);
    const bool stands = c.stand();
    if (!stands && c.controller->fault() == Fault::none) {
      EXPECT_NE(c.last_ack.reason, 0);
      ++refused;
      continue;
    }
    c.upload(testing::still_primitives(leaning(0.25), 3.0));
    for (int tick = 0; tick < 50 && c.controller->state() != SupervisorState::fault; ++tick)
      c.tick();
    found_in_motion += c.controller->fault() == Fault::imu_implausible ? 1 : 0;
  }
  EXPECT_EQ(refused, 20);
  EXPECT_EQ(found_in_motion, 3) << "turned about the vertical: only motion tells";
}

/// A sensor turned about the vertical makes every correction a push: it has to be found in a lean
/// that is too small to do harm.
TEST(ImuWatch, ASmallLeanTellsOfATurnedSensor) {
  for (const double turn : {0.5, 1.0, 1.5}) {
    SCOPED_TRACE(turn);
    EmulatedController c("nominal", mounted(math::quat_exp({0, 0, turn * model::kPi})), false);
    if (c.stand())  // else it was found while the robot settled
      c.upload(testing::still_primitives(leaning(0.06), 3.0));
    for (int tick = 0; tick < 150 && c.controller->state() != SupervisorState::fault; ++tick)
      c.tick();
    EXPECT_EQ(c.controller->fault(), Fault::imu_implausible);
    EXPECT_EQ(c.controller->fault_detail(), ImuWatch::kAgainstLegs);
    c.ticks(150);
    EXPECT_EQ(c.robot.truth().other_contacts, 0) << "it is lowered, not fallen";
  }
}

/// Once the two accounts have agreed, a push onto the edge of the feet is no turned sensor.
TEST(ImuWatch, APushedRobotIsNoTurnedSensor) {
  EmulatedController c("lab");
  ASSERT_TRUE(c.stand());
  for (const double force : {8.0, -8.0, 14.0, -14.0}) {
    c.robot.push({force, 0, 0}, {0, 0, 0}, c.robot.now(), c.robot.now() + 100 * kMillisecond);
    c.ticks(150);
    EXPECT_NE(c.controller->fault(), Fault::imu_implausible) << force;
  }
}

// --- by samples ----------------------------------------------------------------------------------

struct Sensor {
  ImuWatch watch{ImuSettings{}};
  Estimator estimator{EstimatorSettings{}};
  ImuSample sample;
  Sensor() { sample.accel = {0, 0, 9.81}; }
  ImuWatch::Reason run(int ticks) {
    ImuWatch::Reason seen = ImuWatch::kPlausible;
    for (int k = 0; k < ticks; ++k) {
      sample.time += kTickPeriod;
      ++sample.sequence;
      sample.quat_world_base =
          math::quat_multiply(sample.quat_world_base, math::quat_exp(0.01 * turning));
      watch.update(sample.time, sample, estimator, true);
      if (watch.reason() != ImuWatch::kPlausible) seen = watch.reason();
    }
    return seen;
  }
  math::Vec3 turning = math::Vec3::Zero();  // what it really does  rad/s
};

TEST(ImuWatch, OtherUnitsOfForceAreFound) {
  for (const double one_g : {1.0, 981.0, 4.905}) {
    Sensor s;
    s.sample.accel = {0, 0, one_g};
    EXPECT_EQ(s.run(200), ImuWatch::kOtherGravity) << one_g;
  }
  Sensor good;
  EXPECT_EQ(good.run(500), ImuWatch::kPlausible);
}

TEST(ImuWatch, AJumpOfTheOrientationIsFoundAtOnce) {
  Sensor s;
  s.run(100);
  s.sample.quat_world_base = math::quat_exp({0.4, 0, 0});
  EXPECT_EQ(s.run(1), ImuWatch::kRate);
}

TEST(ImuWatch, AnAxisThatFlipsIsFoundInATenthOfASecondOfMotion) {
  Sensor s;
  s.turning = s.sample.gyro = {0, 1.5, 0};
  EXPECT_EQ(s.run(60), ImuWatch::kPlausible);
  s.sample.gyro = {0, -1.5, 0};
  EXPECT_EQ(s.run(10), ImuWatch::kRate);
}

/// Two accounts of the trunk's pitch over soles that lie on one plane: the legs' and the sensor's.
struct Accounts {
  ImuWatch watch{ImuSettings{}};
  Estimator estimator{EstimatorSettings{}};
  ImuSample sample;
  double by_legs = 0, by_sensor = 0;  // rad
  double right_knee = 0;              // bent further: its sole leaves the other's plane  rad
  /// Both go to these values in equal steps, then stay; the last reason that was seen.
  ImuWatch::Reason go(double legs, double sensor, int ticks, bool standing = true) {
    ImuWatch::Reason seen = ImuWatch::kPlausible;
    const double legs_step = (legs - by_legs) / ticks, step = (sensor - by_sensor) / ticks;
    for (int k = 0; k < ticks; ++k) {
      by_legs += legs_step;
      by_sensor += step;
      ServoReadings servos;
      model::Input q = leaning(by_legs);
      q[3] += right_knee;
      for (int j = 0; j < model::kNumJoints; ++j) {
        servos.servo[static_cast<std::size_t>(j)].position_rad = q[j];
        servos.servo[static_cast<std::size_t>(j)].known = true;
      }
      const double rate = legs_step / to_seconds(kTickPeriod);  // of both hips, mirrored
      servos.servo[2].velocity_rad_s = rate, servos.servo[8].velocity_rad_s = -rate;
      sample.time += kTickPeriod;
      ++sample.sequence;
      sample.quat_world_base = math::quat_exp({0, by_sensor, 0});
      sample.gyro = {0, step / to_seconds(kTickPeriod), 0};
      sample.accel =
          math::rotation_matrix(sample.quat_world_base).transpose() * math::Vec3(0, 0, 9.81);
      estimator.update(sample.time, servos, sample, PoseSample{});
      watch.update(sample.time, sample, estimator, standing);
      if (watch.reason() != ImuWatch::kPlausible) seen = watch.reason();
    }
    return seen;
  }
};

constexpr double kSmall_rad = 0.02, kRocking_rad = 0.06;

TEST(ImuWatch, LegsAndSensorThatLeanOppositeWaysContradictEachOther) {
  for (const double way : {1.0, -1.0}) {
    Accounts a;
    EXPECT_EQ(a.go(0, 0, 50), ImuWatch::kPlausible);
    EXPECT_EQ(a.go(way * kSmall_rad, -way * kSmall_rad, 20), ImuWatch::kAgainstLegs);
    Accounts good;
    EXPECT_EQ(good.go(0, 0, 50), ImuWatch::kPlausible);
    EXPECT_EQ(good.go(way * kSmall_rad, way * kSmall_rad, 40), ImuWatch::kPlausible);
    EXPECT_EQ(good.go(way * kSmall_rad, -way * kSmall_rad, 40), ImuWatch::kPlausible)
        << "the two have agreed: a screw does not turn a sensor later";
  }
}

/// Gears with play: the trunk settles by more than a degree and the joints do not say so. Then both
/// turn alike, which a sensor that is turned by a right angle cannot.
TEST(ImuWatch, RatesThatAgreeVouchForTheSensor) {
  for (const double way : {1.0, -1.0}) {
    Accounts a;
    EXPECT_EQ(a.go(0, 0, 50), ImuWatch::kPlausible);
    EXPECT_EQ(a.go(0, -way * 0.025, 100), ImuWatch::kPlausible);
    EXPECT_EQ(a.go(way * 0.014, -way * 0.011, 10), ImuWatch::kPlausible);
  }
}

/// Legs and sensor turn against each other, to and fro.
ImuWatch::Reason against(Accounts& a, int times) {
  ImuWatch::Reason seen = ImuWatch::kPlausible;
  for (int k = 0; k < times; ++k) {
    const double way = k % 2 == 0 ? 0.03 : -0.03;
    const ImuWatch::Reason now = a.go(way, -way, 10);
    if (now != ImuWatch::kPlausible) seen = now;
  }
  return seen;
}

/// A plate under a foot turns the trunk against the legs for a moment; a sensor that came loose
/// does so for good.
TEST(ImuWatch, OnceTheyHaveAgreedAMomentIsNoContradiction) {
  Accounts fresh;
  fresh.go(0, 0, 20);
  EXPECT_EQ(against(fresh, 4), ImuWatch::kAgainstLegs);
  Accounts known;
  known.go(0, 0, 50);
  for (const double lean : {0.02, -0.02, 0.02, 0.0})
    EXPECT_EQ(known.go(lean, lean, 30), ImuWatch::kPlausible);
  EXPECT_EQ(against(known, 4), ImuWatch::kPlausible);
  EXPECT_EQ(against(known, 12), ImuWatch::kAgainstLegs);
}

/// A soft robot rocks before anything is known of its sensor. What legs and sensor say of its rates
/// afterwards vouches for the sensor all the same.
TEST(ImuWatch, ARobotThatHasRockedIsBelievedOnceItsRatesAgree) {
  Accounts rocked;
  rocked.go(0, 0, 50);
  EXPECT_EQ(rocked.go(0, kRocking_rad, 30), ImuWatch::kPlausible);
  Accounts vouched = rocked;
  EXPECT_EQ(against(rocked, 4), ImuWatch::kAgainstLegs);
  for (const double lean : {0.03, -0.03, 0.03, 0.0})
    EXPECT_EQ(vouched.go(lean, kRocking_rad + lean, 20), ImuWatch::kPlausible);
  EXPECT_EQ(against(vouched, 4), ImuWatch::kPlausible);
  EXPECT_EQ(against(vouched, 12), ImuWatch::kAgainstLegs);
}

/// Between two steps the soles lie on one plane for a moment, not all of them on the ground.
TEST(ImuWatch, NothingIsConcludedBetweenTwoSteps) {
  for (const double way : {1.0, -1.0}) {
    Accounts a;
    for (int step = 0; step < 5; ++step) {
      a.right_knee = 0.3;
      EXPECT_EQ(a.go(0, 0, 20), ImuWatch::kPlausible);
      a.right_knee = 0;
      EXPECT_EQ(a.go(way * kSmall_rad, -way * kSmall_rad, 20), ImuWatch::kPlausible);
    }
    a.right_knee = 0.3;
    EXPECT_EQ(a.go(0, 0, 20), ImuWatch::kPlausible);
    a.right_knee = 0;
    EXPECT_EQ(a.go(0, 0, 50), ImuWatch::kPlausible);
    EXPECT_EQ(a.go(way * kSmall_rad, -way * kSmall_rad, 20), ImuWatch::kAgainstLegs)
        << "it stands: now it tells";
  }
}

/// A robot that is pushed rocks on the edge of its soles, and a balance that leans its legs against
/// it says the opposite of its sensor: nothing is concluded from that until torque has been off.
TEST(ImuWatch, NothingIsConcludedOfARobotThatRocksUntilItsTorqueIsOff) {
  for (const double way : {1.0, -1.0}) {
    Accounts a;
    EXPECT_EQ(a.go(0, 0, 50), ImuWatch::kPlausible);
    EXPECT_EQ(a.go(0, way * kRocking_rad, 30), ImuWatch::kPlausible);
    EXPECT_EQ(a.go(-way * kSmall_rad, way * kSmall_rad, 20), ImuWatch::kPlausible);
    EXPECT_EQ(a.go(-way * kSmall_rad, way * kSmall_rad, 100), ImuWatch::kPlausible);
    EXPECT_EQ(a.go(0, 0, 20, false), ImuWatch::kPlausible);
    EXPECT_EQ(a.go(0, 0, 50), ImuWatch::kPlausible);
    EXPECT_EQ(a.go(-way * kSmall_rad, way * kSmall_rad, 20), ImuWatch::kAgainstLegs)
        << "on its soles again it tells as before";
  }
}

}  // namespace
}  // namespace sanso::firmware
