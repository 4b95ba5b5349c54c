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

/// Target, previous and reading have nothing to do with one another, and some are no numbers.
TEST(Guard, WhateverGoesInWhatComesOutIsFiniteAndNoStep) {
  const unsigned seed = 11;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> wide(-2 * model::kPi, 2 * model::kPi);
  const auto any = [&] {
    switch (random() % 12) {
      case 0:
        return std::numeric_limits<double>::quiet_NaN();
      case 1:
        return std::numeric_limits<double>::infinity();
      case 2:
        return -std::numeric_limits<double>::infinity();
      default:
        return wide(random);
    }
  };
  const Guard guard = make_guard();
  const double step = kSettings.guard.max_target_rate_rad_s * 0.01 + 1e-12;
  for (int n = 0; n < 5000; ++n) {
    model::Input wanted, previous, q;
    std::array<double, kNumHeld> held{}, held_before{};
    for (int j = 0; j < model::kNumJoints; ++j) {
      wanted[j] = any();
      previous[j] = any();
      q[j] = any();
    }
    for (std::size_t k = 0; k < kNumHeld; ++k) {
      held[k] = any();
      held_before[k] = any();
    }
    LimitSet limits;
    const model::Input out = guard.limit(wanted, previous, q, limits);
    for (int j = 0; j < model::kNumJoints; ++j) {
      const model::JointInfo& joint = model::kJoints[static_cast<std::size_t>(j)];
      const double low = joint.lower_rad + kSettings.guard.joint_margin_rad;
      const double high = joint.upper_rad - kSettings.guard.joint_margin_rad;
      ASSERT_TRUE(std::isfinite(out[j]));
      const bool was_inside = previous[j] >= low && previous[j] <= high;
      if (was_inside || !std::isfinite(previous[j])) {
        ASSERT_GE(out[j], low - 1e-12) << joint.name;
        ASSERT_LE(out[j], high + 1e-12) << joint.name;
      }
      if (!std::isfinite(previous[j])) continue;
      ASSERT_LE(std::abs(out[j] - previous[j]), step) << joint.name;
      if (!was_inside) {
        const double before = previous[j] < low ? low - previous[j] : previous[j] - high;
        const double after = previous[j] < low ? low - out[j] : out[j] - high;
        ASSERT_LT(after, before) << "on its way in: " << joint.name;
      }
    }
    const auto moved = guard.limit_held(held, held_before, limits);
    for (std::size_t k = 0; k < kNumHeld; ++k) {
      ASSERT_TRUE(std::isfinite(moved[k]));
      if (std::isfinite(held_before[k])) {
        ASSERT_LE(std::abs(moved[k] - held_before[k]),
                  kSettings.guard.max_held_rate_rad_s * 0.01 + 1e-12);
      }
    }
  }
}

TEST(Guard, AJointOutsideItsRangeComesInSlowly) {
  const Guard guard = make_guard();
  model::Input u = model::Input::Zero();
  u[3] = model::kJoints[3].upper_rad + 0.5;
  LimitSet limits;
  int ticks = 0;
  for (; u[3] > model::kJoints[3].upper_rad; ++ticks) {
    const double before = u[3];
    u = guard.limit(model::Input::Zero(), u, u, limits);
    ASSERT_LE(before - u[3], 0.0051);
    ASSERT_LT(ticks, 200);
  }
  EXPECT_TRUE(limits.has(Limit::joint_rate));
}

TEST(Guard, AHotServoMayUseLessOfTheSupply) {
  const Guard guard = make_guard();
  const GuardSettings& s = kSettings.guard;
  EXPECT_EQ(guard.allowed_duty(30), s.max_duty);
  EXPECT_EQ(guard.allowed_duty(s.warm_temperature_C), s.max_duty);
  EXPECT_NEAR(guard.allowed_duty(0.5 * (s.warm_temperature_C + s.max_temperature_C)),
              0.5 * (s.max_duty + s.hot_duty), 1e-12);
  EXPECT_NEAR(guard.allowed_duty(90), s.hot_duty, 1e-12);
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

/// One servo's voltage is read every 40 ms, each servo's every 0.8 s.
GuardVerdict watch_supply(Guard& guard, ServoReadings& r, double low_from_s, double low_until_s,
                          double until_s) {
  GuardVerdict verdict, worst;
  ImuSample imu;
  for (int tick = 1; tick <= static_cast<int>(100 * until_s); ++tick) {
    GuardSituation s;
    s.now = kSecond + tick * kTickPeriod;
    imu.time = s.now;
    ++imu.changes;
    if (tick % 4 == 0) {
      ServoHealth& health = r.health[static_cast<std::size_t>(tick / 4) % kNumServos];
      const double t = 0.01 * tick;
      health.voltage_V = t >= low_from_s && t < low_until_s ? 9.5f : 12.0f;
      ++health.supply_reads;
    }
    verdict = guard.watch(s, r, imu);
    if (verdict.fault != Fault::none && worst.fault == Fault::none) worst = verdict;
  }
  return worst;
}

TEST(Guard, AShortSagInformsALongOneIsAFault) {
  for (const double begin : {0.50, 0.51, 0.52, 0.53}) {
    Guard guard = make_guard();
    ServoReadings r = good_readings();
    EXPECT_EQ(watch_supply(guard, r, begin, begin + 0.06, 3.0).fault, Fault::none);
    EXPECT_EQ(watch_supply(guard, r, begin, begin + 0.25, 3.0).fault, Fault::none);
    Guard other = make_guard();
    const GuardVerdict v = watch_supply(other, r, begin, begin + 0.4, 3.0);
    EXPECT_EQ(v.fault, Fault::under_voltage);
    EXPECT_EQ(v.detail, 95);
    EXPECT_TRUE(v.must_lower);
  }
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

TEST(Guard, LateTicksAreCountedInAWindow) {
  GuardSituation s;
  const auto run = [&](Guard& guard, int every, int ticks) {
    Fault fault = Fault::none;
    for (int k = 0; k < ticks; ++k) {
      s.late = k % every == 0;
      const GuardVerdict v = watch(guard, good_readings(), 1, s);
      EXPECT_EQ(v.limits.has(Limit::late_tick), s.late);
      if (v.fault != Fault::none) fault = v.fault;
    }
    return fault;
  };
  Guard in_a_row = make_guard(), every_second = make_guard(), every_tenth = make_guard();
  EXPECT_EQ(run(in_a_row, 1, kSettings.guard.overrun_ticks - 1), Fault::none);
  EXPECT_EQ(run(in_a_row, 1, 1), Fault::tick_overrun);
  EXPECT_EQ(run(every_second, 2, 100), Fault::tick_overrun);
  EXPECT_EQ(run(every_tenth, 10, 1000), Fault::none);
}

/// An arm or head servo that falls silent while it is meant to move.
TEST(Guard, ASilentArmIsAFaultWhileItIsAsked) {
  Guard guard = make_guard();
  ServoReadings r = good_readings();
  r.servo[14].age_ticks = 50;
  EXPECT_EQ(watch(guard, r).fault, Fault::none) << "not asked in a trial";
  GuardSituation s;
  s.watch_held = true;
  EXPECT_EQ(watch(guard, r, 1, s).fault, Fault::servo_silent);
  EXPECT_EQ(watch(guard, r, 1, s).detail, kServoIds[14]);
}

TEST(Guard, AFallIsSeenBehindAnotherFault) {
  Guard guard = make_guard();
  ServoReadings r = good_readings();
  r.servo[4].age_ticks = 50;
  GuardSituation s;
  s.standing = true;
  s.tilt = 1.2;
  const GuardVerdict v = watch(guard, r, 10, s);
  EXPECT_EQ(v.fault, Fault::servo_silent);
  EXPECT_TRUE(v.fallen);
}

}  // namespace
}  // namespace sanso::firmware
