// The estimator against what really is in the emulated robot: noise, quantised encoders, delays,
// pushes.
#include "firmware/estimate/estimator.h"

#include <gtest/gtest.h>

#include "tests/firmware/support/emulated_controller.h"

namespace sanso::firmware {
namespace {

using testing::EmulatedController;

struct Errors {
  double position = 0, velocity = 0, tilt = 0;  // root mean square: m, m/s, rad
};

/// Runs a trial of two seconds with a push in it and compares the estimate with the truth, both
/// from the trial's origin.
Errors run_trial(EmulatedController& c) {
  EXPECT_TRUE(c.stand());
  c.command(wire::CommandKind::start_trial, 1, 200, policy::LayerSwitches::kLower);
  const model::State origin = c.truth();
  const Nanoseconds now = c.robot.now();
  c.robot.push({4.0, 2.0, 0.0}, {0, 0, 0}, now + 300 * kMillisecond, now + 400 * kMillisecond);
  Errors e;
  const int ticks = 190;
  for (int k = 0; k < ticks; ++k) {
    const model::State truth = c.truth();
    c.tick();
    const model::State& x = c.seen().x;
    const math::Vec3 moved = truth.segment<3>(model::kXPos) - math::Vec3(origin[0], origin[1], 0.0);
    e.position += (x.segment<3>(model::kXPos) - moved).squaredNorm();
    e.velocity += (x.segment<3>(model::kXVel) - truth.segment<3>(model::kXVel)).squaredNorm();
    e.tilt +=
        math::quat_minus(model::base_quat(x), model::base_quat(truth)).head<2>().squaredNorm();
  }
  EXPECT_EQ(c.controller->state(), wire::SupervisorState::run);
  e.position = std::sqrt(e.position / ticks);
  e.velocity = std::sqrt(e.velocity / ticks);
  e.tilt = std::sqrt(e.tilt / ticks);
  ::testing::Test::RecordProperty("position_mm", std::to_string(1e3 * e.position));
  ::testing::Test::RecordProperty("velocity_mm_s", std::to_string(1e3 * e.velocity));
  return e;
}

// Bounds: three times what was measured (docs/results/estimator.md); the motions' weights ask for 5
// mm and 0.05 m/s.
TEST(Estimator, FollowsAPushedRobotWithThePoseSource) {
  EmulatedController c("lab");
  const Errors e = run_trial(c);
  EXPECT_LT(e.position, 0.002);
  EXPECT_LT(e.velocity, 0.02);
  EXPECT_LT(e.tilt, 0.02);
  EXPECT_LT(c.seen().pose_age_ticks, 10);
}

TEST(Estimator, FollowsAPushedRobotFromLegsAndImuAlone) {
  EmulatedController c("lab", {}, false);
  const Errors e = run_trial(c);
  EXPECT_LT(e.position, 0.002);
  EXPECT_LT(e.velocity, 0.02);
  EXPECT_EQ(c.seen().pose_age_ticks, 255);
}

/// Down the ramp on wheels, from a hand's push to the run-out.
Errors roll_down(bool wheels_told, bool with_pose) {
  Settings settings;
  settings.estimator.wheels = wheels_told;
  settings.estimator.flat_ground = false;
  EmulatedController c("lab+ramp+wheels", settings, with_pose);
  c.robot.lend_hand({0.5, 0.5});
  EXPECT_TRUE(c.stand());
  c.command(wire::CommandKind::start_trial, 1, 400, policy::LayerSwitches::kLower);
  c.robot.push_off();
  const model::State origin = c.truth();
  Errors e;
  int ticks = 0;
  for (; ticks < 350 && c.truth()[0] < origin[0] + 1.2; ++ticks) {
    c.tick();
    const model::State truth = c.truth(), x = c.seen().x;
    const math::Vec3 moved = truth.segment<3>(model::kXPos) - math::Vec3(origin[0], origin[1], 0.0);
    e.position += (x.segment<3>(model::kXPos) - moved).squaredNorm();
    e.velocity += (x.segment<3>(model::kXVel) - truth.segment<3>(model::kXVel)).squaredNorm();
  }
  EXPECT_GT(c.truth()[0], origin[0] + 1.2);
  EXPECT_EQ(c.controller->state(), wire::SupervisorState::run);
  return {std::sqrt(e.position / ticks), std::sqrt(e.velocity / ticks), 0.0};
}

TEST(Estimator, FollowsARobotThatRollsDownARamp) {
  const Errors told = roll_down(true, true), believes_in_soles = roll_down(false, true);
  std::printf("on wheels: %.1f mm, %.1f mm/s; taken for soles: %.1f mm, %.1f mm/s\n",
              1e3 * told.position, 1e3 * told.velocity, 1e3 * believes_in_soles.position,
              1e3 * believes_in_soles.velocity);
  EXPECT_LT(told.position, 0.010);
  EXPECT_LT(told.velocity, 0.05);
  EXPECT_GT(believes_in_soles.velocity, 5 * told.velocity);
}

TEST(Estimator, WithoutAPoseSourceOnlyTheWayAlongTheWheelsIsLeftToTheImu) {
  const Errors blind = roll_down(true, false);
  std::printf("without a pose source: %.1f mm, %.1f mm/s\n", 1e3 * blind.position,
              1e3 * blind.velocity);
  // the accelerometer's 0.05 m/s^2 over the three seconds of the hold and three of the way
  EXPECT_LT(blind.velocity, 0.4);
}

TEST(Estimator, KnowsThatARobotInTheAirStandsOnNothing) {
  Settings settings;
  settings.estimator.wheels = true;
  settings.estimator.flat_ground = false;
  EmulatedController c("lab+jump_ramp+wheels", settings);
  c.robot.lend_hand({0.5, 0.5});
  ASSERT_TRUE(c.stand());
  c.command(wire::CommandKind::start_trial, 1, 400, policy::LayerSwitches::kLower);
  c.robot.push_off();
  int airborne = 0, noticed = 0;
  double worst_height_m = 0.0;
  for (int k = 0; k < 250 && c.truth()[0] < 1.38; ++k) {
    c.tick();
    const auto contacts = c.robot.truth().foot_contacts;
    if (contacts[0] + contacts[1] > 0) continue;
    ++airborne;
    noticed += c.seen().contact == 0 ? 1 : 0;
    worst_height_m = std::max(worst_height_m, std::abs(c.seen().x[2] - c.truth()[2]));
  }
  std::printf("in the air for %d ticks, noticed in %d; height within %.1f mm\n", airborne, noticed,
              1e3 * worst_height_m);
  EXPECT_GE(airborne, 5);
  EXPECT_GE(noticed, airborne / 2);  // a tick and the IMU's age late
  EXPECT_LT(worst_height_m, 0.006);
}

/// Thrown straight up from its soles: what is lower of the two feet stands on nothing either.
TEST(Estimator, BothSolesOfAThrownRobotAreFree) {
  EmulatedController c("lab");
  ASSERT_TRUE(c.stand());
  c.command(wire::CommandKind::start_trial, 1, 200, policy::LayerSwitches::kLower);
  const Nanoseconds now = c.robot.now();
  c.robot.push({0.0, 0.0, 90.0}, {0, 0, 0}, now + 100 * kMillisecond, now + 160 * kMillisecond);
  int airborne = 0, noticed = 0;
  double worst_height_m = 0.0, worst_velocity = 0.0;
  for (int k = 0; k < 40; ++k) {
    c.tick();
    const auto contacts = c.robot.truth().foot_contacts;
    if (contacts[0] + contacts[1] > 0 || c.robot.now() < now + 180 * kMillisecond) continue;
    ++airborne;
    noticed += c.seen().contact == 0 ? 1 : 0;
    worst_height_m = std::max(worst_height_m, std::abs(c.seen().x[2] - c.truth()[2]));
    worst_velocity = std::max(worst_velocity,
                              std::abs(c.seen().x[model::kXVel + 2] - c.truth()[model::kXVel + 2]));
  }
  std::printf("in the air for %d ticks, noticed in %d; height within %.1f mm, velocity %.0f mm/s\n",
              airborne, noticed, 1e3 * worst_height_m, 1e3 * worst_velocity);
  EXPECT_GE(airborne, 5);
  EXPECT_GE(noticed, airborne / 2);  // a tick and the IMU's age late
}

TEST(Estimator, StartsEveryTrialAtTheOriginWithHeadingZero) {
  EmulatedController c("nominal");
  emulator::Placement away;
  away.x_m = 1.0;
  away.y_m = -2.0;
  away.yaw_rad = 1.0;
  ASSERT_TRUE(c.stand(testing::standing_pose(), 3.0, away));
  c.command(wire::CommandKind::start_trial, 1, 100, policy::LayerSwitches::kLower);
  EXPECT_EQ(c.seen().trial_tick, 0);
  EXPECT_NEAR(c.seen().x[0], 0.0, 1e-9);
  EXPECT_NEAR(c.seen().x[1], 0.0, 1e-9);
  EXPECT_NEAR(math::yaw_of(model::base_quat(c.seen().x)), 0.0, 1e-9);
  EXPECT_NEAR(c.seen().x[2], c.truth()[2], 0.004);
}

/// A trunk that swings along x above soles that say little, seen by a camera `delay` ago. Root mean
/// square of the velocity's error [m/s].
double velocity_error(Nanoseconds delay) {
  EstimatorSettings s;
  s.foot_velocity_noise = 1.0;
  s.foot_slip_noise = 1.0;
  s.foot_position_noise_m = 0.05;
  s.pose_velocity_noise = 0.005;
  Estimator estimator(s);
  ServoReadings servos;
  for (std::size_t j = 0; j < model::kNumJoints; ++j) {
    servos.servo[j].known = true;
    servos.servo[j].position_rad = testing::standing_pose()[static_cast<Eigen::Index>(j)];
  }
  constexpr double kAmplitude = 8.0, kRate = 2.0 * 3.14159265358979 * 2.0;  // m/s^2, rad/s
  const auto velocity = [](double t) { return -kAmplitude / kRate * std::cos(kRate * t); };
  double square = 0.0;
  constexpr int kSettle = 100, kTicks = 300;
  for (int k = 1; k <= kTicks; ++k) {
    const Nanoseconds now = k * kTickPeriod;
    const double t = to_seconds(now), then = t - to_seconds(delay);
    ImuSample imu;
    imu.time = now;
    // the mean of the tick that has passed, as the sensor's own filter gives it
    imu.accel = {(velocity(t) - velocity(t - 0.01)) / 0.01, 0.0, 9.81};
    PoseSample pose;
    pose.time = now - delay;
    pose.sequence = static_cast<std::uint32_t>(k);
    pose.confidence = 3;
    pose.p_track_base = {-kAmplitude / (kRate * kRate) * std::sin(kRate * then), 0.0, 0.25};
    pose.v_base_in_track = {velocity(then), 0.0, 0.0};
    const model::State& x = estimator.update(now, servos, imu, pose);
    if (k > kSettle) square += std::pow(x[model::kXVel] - velocity(t), 2) / (kTicks - kSettle);
  }
  return std::sqrt(square);
}

TEST(Estimator, AnOldVelocityCorrectsTheVelocityOfThen) {
  const double fresh = velocity_error(0), old = velocity_error(20 * kMillisecond);
  EXPECT_LT(fresh, 0.03);
  // 20 ms at 8 m/s^2 are 0.16 m/s: what comes of taking the old velocity for the present one
  EXPECT_LT(old, fresh + 0.02);
}

TEST(AxisFilter, KnownAccelerationIsFollowedExactlyWithoutNoise) {
  AxisFilter filter;
  filter.reset(0.0, 0.1, -0.1, 0.01);
  for (int k = 0; k < 100; ++k) filter.predict(2.0, 0.01, 0.1, 0.01, 0.01);
  EXPECT_NEAR(filter.position(), 1.0, 1e-12);
  EXPECT_NEAR(filter.velocity(), 2.0, 1e-12);
}

TEST(AxisFilter, CovarianceStaysPositiveAndMeasurementsShrinkIt) {
  AxisFilter filter;
  filter.reset(0.0, 0.1, -0.1, 0.1);
  double before = filter.P()(0, 0);
  for (int k = 0; k < 5000; ++k) {
    filter.predict(0.0, 0.01, 0.5, 0.02, 10.0);
    filter.measure(AxisFilter::Vec4::Unit(AxisFilter::kRightSole) -
                       AxisFilter::Vec4::Unit(AxisFilter::kPosition),
                   0.1, 0.002);
    filter.measure(AxisFilter::Vec4::Unit(AxisFilter::kVelocity), 0.0, 0.05);
    for (int i = 0; i < 4; ++i) ASSERT_GT(filter.P()(i, i), 0.0);
  }
  EXPECT_LT(filter.P()(AxisFilter::kVelocity, AxisFilter::kVelocity), before);
  EXPECT_NEAR(filter.velocity(), 0.0, 1e-6);
}

}  // namespace
}  // namespace sanso::firmware
