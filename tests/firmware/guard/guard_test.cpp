// The guard: what leaves it is safe whatever goes in; every fault has its cause and its number.
#include "firmware/guard/guard.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "shared/model/joints.h"
#include "shared/servo_bus/xm430.h"

namespace sanso::firmware {
namespace {

const Settings kSettings;

Guard make_guard() { return Guard(kSettings.guard, kSettings.bus, kSettings.imu); }

ServoReadings good_readings() {
  ServoReadings r;
  r.asked = r.answered = model::kNumJoints;
  for (auto& s : r.servo) s.known = true;
  for (auto& h : r.health) {
    h.voltage_V = 12.0f;
    h.temperature_C = 35.0f;
    h.torque_known = h.torque_on = true;
  }
  return r;
}

/// Runs `ticks` ticks with a living IMU; the last verdict.
GuardVerdict watch(Guard& guard, const ServoReadings& readings, int ticks = 1,
                   GuardSituation s = {}, bool imu_alive = true, bool imu_moves = true) {
  ImuSample imu;
  imu.time = imu_alive ? s.now : 0;
  GuardVerdict verdict;
  for (int i = 0; i < ticks; ++i) {
    s.now += kTickPeriod;
    if (imu_alive) imu.time = s.now;
    if (imu_moves) ++imu.changes;
    verdict = guard.watch(s, readings, imu);
  }
  return verdict;
}

TEST(Guard, NothingWrongIsNoFaultAndNoLimit) {
  Guard guard = make_guard();
  const GuardVerdict v = watch(guard, good_readings(), 100);
  EXPECT_EQ(v.fault, Fault::none);
  EXPECT_EQ(v.limits.bits(), 0u);
}

TEST(Guard, WhateverGoesInWhatComesOutIsInsideEveryLimit) {
  const unsigned seed = 11;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> wide(-10, 10), inside(-0.3, 0.3);
  const Guard guard = make_guard();
  for (int n = 0; n < 2000; ++n) {
    model::Input wanted, previous, q;
    for (int j = 0; j < model::kNumJoints; ++j) {
      wanted[j] = n % 7 == 0 ? std::numeric_limits<double>::quiet_NaN() : wide(random);
      previous[j] = inside(random);
      q[j] = previous[j] + 0.1 * inside(random);
    }
    LimitSet limits;
    const model::Input out = guard.limit(wanted, previous, q, limits);
    for (int j = 0; j < model::kNumJoints; ++j) {
      const model::JointInfo& joint = model::kJoints[static_cast<std::size_t>(j)];
      ASSERT_TRUE(std::isfinite(out[j]));
      ASSERT_GE(out[j], joint.lower_rad + kSettings.guard.joint_margin_rad - 1e-12) << joint.name;
      ASSERT_LE(out[j], joint.upper_rad - kSettings.guard.joint_margin_rad + 1e-12) << joint.name;
      ASSERT_LE(std::abs(out[j] - previous[j]),
                kSettings.guard.max_target_rate_rad_s * 0.01 + 1e-12)
          << joint.name;
    }
  }
}

TEST(Guard, ATargetInsideItsLimitsPassesUnchanged) {
  const Guard guard = make_guard();
  model::Input previous = model::Input::Zero();
  const model::Input wanted = model::Input::Constant(0.05);
  LimitSet limits;
  EXPECT_EQ(guard.limit(wanted, previous, previous, limits), wanted);
  EXPECT_EQ(limits.bits(), 0u);
}

TEST(Guard, EachLimitIsNamed) {
  const Guard guard = make_guard();
  const model::Input zero = model::Input::Zero();
  LimitSet rate, torque, range;
  guard.limit(model::Input::Constant(0.2), zero, zero, rate);
  EXPECT_TRUE(rate.has(Limit::joint_rate));
  guard.limit(zero, zero, model::Input::Constant(-0.7), torque);
  EXPECT_TRUE(torque.has(Limit::servo_torque));
  model::Input at_limit = zero;
  at_limit[1] = 0.3 * model::kPi;
  guard.limit(at_limit, at_limit, at_limit, range);
  EXPECT_TRUE(range.has(Limit::joint_range));
}

TEST(Guard, OneSilentServoIsNamedAllSilentIsTheBus) {
  Guard guard = make_guard();
  ServoReadings r = good_readings();
  r.answered = 11;
  r.servo[4].age_ticks = static_cast<std::uint16_t>(kSettings.bus.silent_ticks - 1);
  EXPECT_EQ(watch(guard, r).fault, Fault::none);
  EXPECT_TRUE(watch(guard, r).limits.has(Limit::bus_loss));
  r.servo[4].age_ticks = static_cast<std::uint16_t>(kSettings.bus.silent_ticks);
  EXPECT_EQ(watch(guard, r).fault, Fault::servo_silent);
  EXPECT_EQ(watch(guard, r).detail, 15);  // r_ank_pitch
  for (std::size_t j = 0; j < model::kNumJoints; ++j) r.servo[j].age_ticks = 50;
  EXPECT_EQ(watch(guard, r).fault, Fault::bus_silent);
  r.port_gone = true;
  EXPECT_EQ(watch(guard, r).fault, Fault::bus_gone);
}

TEST(Guard, HotOverloadedAndBrokenServosAreToldApart) {
  namespace xm430 = servo_bus::xm430;
  Guard guard = make_guard();
  ServoReadings r = good_readings();
  r.health[3].temperature_C = 70;
  EXPECT_TRUE(watch(guard, r).limits.has(Limit::temperature));
  EXPECT_EQ(watch(guard, r).fault, Fault::none);
  r.health[3].temperature_C = 80;
  EXPECT_EQ(watch(guard, r).fault, Fault::over_temperature);
  EXPECT_EQ(watch(guard, r).detail, 13);
  r = good_readings();
  r.health[3].hardware_error = xm430::kErrorOverload;
  EXPECT_EQ(watch(guard, r).fault, Fault::overload);
  r.health[3].hardware_error = xm430::kErrorEncoder;
  EXPECT_EQ(watch(guard, r).fault, Fault::servo_hardware);
  r.health[3].hardware_error = xm430::kErrorVoltage;
  EXPECT_EQ(watch(guard, r).fault, Fault::none);
  EXPECT_TRUE(watch(guard, r).limits.has(Limit::voltage));
}

TEST(Guard, TorqueLostIsAFaultOnlyWhenTorqueIsExpected) {
  Guard guard = make_guard();
  ServoReadings r = good_readings();
  r.health[0].torque_on = false;
  EXPECT_EQ(watch(guard, r).fault, Fault::none);
  GuardSituation s;
  s.torque_expected = true;
  EXPECT_EQ(watch(guard, r, 1, s).fault, Fault::torque_lost);
}

TEST(Guard, ABriefVoltageDipInformsALongOneIsAFault) {
  Guard guard = make_guard();
  ServoReadings r = good_readings();
  r.health[5].voltage_V = 9.0f;
  EXPECT_EQ(watch(guard, r, 29).fault, Fault::none);
  const GuardVerdict v = watch(guard, r, 1);
  EXPECT_EQ(v.fault, Fault::under_voltage);
  EXPECT_EQ(v.detail, 90);
}

TEST(Guard, ASilentAndAFrozenImuAreToldApart) {
  Guard guard = make_guard();
  GuardSituation s;
  s.now = kSecond;
  EXPECT_EQ(watch(guard, good_readings(), 1, s, false).fault, Fault::imu_silent);
  Guard other = make_guard();
  EXPECT_EQ(watch(other, good_readings(), 10, s, true, false).fault, Fault::none);
  Guard third = make_guard();
  EXPECT_EQ(watch(third, good_readings(), 12, s, true, false).fault, Fault::imu_frozen);
}

TEST(Guard, AFallHasToLastAndCountsOnlyWhenStanding) {
  Guard guard = make_guard();
  GuardSituation s;
  s.tilt = 1.2;
  s.height = 0.2;
  EXPECT_EQ(watch(guard, good_readings(), 50, s).fault, Fault::none);
  s.standing = true;
  EXPECT_EQ(watch(guard, good_readings(), 4, s).fault, Fault::none);
  EXPECT_EQ(watch(guard, good_readings(), 1, s).fault, Fault::fallen);
}

TEST(Guard, LateTicksInARowAreAFault) {
  Guard guard = make_guard();
  GuardSituation s;
  s.late_in_a_row = kSettings.guard.overrun_ticks - 1;
  EXPECT_TRUE(watch(guard, good_readings(), 1, s).limits.has(Limit::late_tick));
  s.late_in_a_row = kSettings.guard.overrun_ticks;
  EXPECT_EQ(watch(guard, good_readings(), 1, s).fault, Fault::tick_overrun);
}

}  // namespace
}  // namespace sanso::firmware
