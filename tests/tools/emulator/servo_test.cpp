// One servo's laws: stiffness, speed line, limits, heat, overload, watchdog.
#include "tools/emulator/servo.h"

#include <gtest/gtest.h>

#include "shared/servo_bus/units.h"
#include "tools/plant/gear_train.h"

namespace sanso::emulator {
namespace {

namespace xm = servo_bus::xm430;
using servo_bus::StatusError;

/// A servo on a bench: horn loaded with a torque, or held by hand.
struct Bench {
  explicit Bench(plant::ServoParameters p = {}) : parameters(p), servo(7, p) {
    servo.set_power(true, 0);
    run(1.2);
    set(xm::kPositionPGain, 560);
  }
  void set(const servo_bus::Register& r, std::int64_t value) {
    std::uint8_t data[4];
    servo_bus::put_le(data, r.size, value);
    ASSERT_EQ(servo.write(r.address, {data, r.size}, now), StatusError::none) << r.name;
  }
  StatusError try_set(const servo_bus::Register& r, std::int64_t value) {
    std::uint8_t data[4];
    servo_bus::put_le(data, r.size, value);
    return servo.write(r.address, {data, r.size}, now);
  }
  std::int64_t get(const servo_bus::Register& r) const { return servo.registers().get(r); }

  void run(double seconds) {
    constexpr double h = 0.0005;
    const plant::GearTrainParameters g{
        parameters.resistance_ohm,        parameters.torque_constant_Nm_A,
        parameters.back_emf_V_s,          parameters.motor_inertia_kgm2,
        parameters.gear_stiffness_Nm_rad, parameters.gear_damping_Nms_rad,
        parameters.backlash_rad,          parameters.coulomb_Nm,
        parameters.stribeck_extra_Nm,     parameters.stribeck_velocity_rad_s,
        parameters.load_friction,         parameters.viscous_Nms_rad};
    for (int k = 0; k < seconds / h; ++k) {
      if (k % 2 == 0) drive = servo.update(now, 2 * h, {link, link_rate, gear.current_A, supply});
      gear.step(g, h, drive.powered, drive.duty * supply, link, link_rate);
      if (!hand) {  // a link of 0.01 kg m^2 under a constant torque
        link_rate += h * (gear.gear_torque_Nm + load) / (0.01 + parameters.output_inertia_kgm2);
        link += h * link_rate;
      }
      now += from_seconds(h);
    }
  }

  plant::ServoParameters parameters;
  Servo servo;
  plant::GearTrain gear;
  ServoDrive drive;
  Nanoseconds now = 0;
  double link = 0, link_rate = 0, load = 0, supply = 12;
  bool hand = false;
};

TEST(Servo, DroopUnderOneNewtonMetreIsThePLawsFigure) {
  // duty = P / 128 x 651.9 / 885 a rad, torque = stall x duty: 13.21 N m/rad at 12 V, 4.3 deg for 1
  // N m
  Bench bench;
  bench.set(xm::kGoalPosition, 2048);
  bench.set(xm::kTorqueEnable, 1);
  bench.load = -1.0;
  bench.run(4.0);
  EXPECT_NEAR(bench.link * 180 / plant::kPi, -4.34, 0.10);  // an encoder count is 0.09 deg
  bench.set(xm::kPositionPGain, 800);
  bench.run(4.0);
  EXPECT_NEAR(bench.link * 180 / plant::kPi, -3.04, 0.10);
}

TEST(Servo, PwmIsAnIntegerMultipleOfTheErrorInCounts) {
  Bench bench;
  bench.hand = true;
  bench.set(xm::kTorqueEnable, 1);
  bench.set(xm::kGoalPosition, 2048 + 64);
  bench.run(0.05);
  EXPECT_EQ(bench.get(xm::kPresentPwm), 64 * 560 / 128);
  EXPECT_DOUBLE_EQ(bench.drive.duty, 280.0 / 885.0);
}

TEST(Servo, StallTorqueAndNoLoadSpeedAreTheDataSheets) {
  for (const auto& [volt, stall, speed] :
       {std::tuple{12.0, 4.1, 4.82}, {11.1, 3.8, 4.50}, {14.8, 4.8, 5.97}}) {
    Bench bench;
    bench.supply = volt;
    bench.set(xm::kOperatingMode, 16);
    bench.set(xm::kTorqueEnable, 1);
    bench.set(xm::kGoalPwm, 885);
    bench.run(1.5);
    EXPECT_NEAR(bench.link_rate, speed, 0.02 * speed) << volt << " V";
    bench.hand = true;
    bench.link_rate = 0;
    bench.run(0.3);
    EXPECT_NEAR(bench.gear.gear_torque_Nm, stall, 0.06 * stall) << volt << " V";
  }
}

TEST(Servo, TorqueFallsInAStraightLineWithSpeed) {
  Bench bench;
  bench.set(xm::kOperatingMode, 16);
  bench.set(xm::kTorqueEnable, 1);
  bench.set(xm::kGoalPwm, 885);
  for (const double load : {0.0, 1.0, 2.0, 3.0}) {
    bench.load = -load;
    bench.run(1.0);
    EXPECT_NEAR(bench.link_rate, 4.82 * (1 - load / 4.1), 0.05) << load << " N m";
  }
}

TEST(Servo, PwmLimitBoundsTheDuty) {
  Bench bench;
  bench.hand = true;
  bench.set(xm::kPwmLimit, 300);
  bench.set(xm::kGoalPwm, 300);
  bench.set(xm::kTorqueEnable, 1);
  bench.set(xm::kGoalPosition, 4000);
  bench.run(0.05);
  EXPECT_EQ(bench.get(xm::kPresentPwm), 300);
}

TEST(Servo, GoalTakesTheCommandDelayToAct) {
  plant::ServoParameters p;
  p.command_delay_s = 0.012;
  Bench bench(p);
  bench.hand = true;
  bench.set(xm::kGoalPosition, 2048);
  bench.set(xm::kTorqueEnable, 1);
  bench.run(0.1);
  bench.set(xm::kGoalPosition, 2148);
  bench.run(0.010);
  EXPECT_EQ(bench.get(xm::kPresentPwm), 0);
  bench.run(0.004);
  EXPECT_NE(bench.get(xm::kPresentPwm), 0);
}

TEST(Servo, PresentValuesAreAsOldAsTheSensorDelay) {
  plant::ServoParameters p;
  p.sensor_delay_s = 0.02;
  Bench bench(p);
  bench.hand = true;
  bench.run(0.2);
  bench.link = 0.5;
  bench.run(0.018);
  EXPECT_EQ(bench.get(xm::kPresentPosition), 2048);
  bench.run(0.004);
  EXPECT_EQ(bench.get(xm::kPresentPosition), servo_bus::position_raw(0.5));
}

TEST(Servo, ProfileVelocityLimitsTheTrajectory) {
  Bench bench;
  bench.hand = true;
  bench.set(xm::kGoalPosition, 2048);
  bench.set(xm::kTorqueEnable, 1);
  bench.run(0.05);
  bench.set(xm::kProfileVelocity, 20);  // 20 x 0.229 rpm = 0.48 rad/s = 312.7 counts/s
  bench.set(xm::kGoalPosition, 3048);
  bench.run(1.0);
  EXPECT_NEAR(static_cast<double>(bench.get(xm::kPositionTrajectory)), 2048 + 312.7, 3);
}

TEST(Servo, OverheatShutsDownAndOnlyARebootClearsIt) {
  Bench bench;
  bench.set(xm::kTorqueEnable, 1);
  bench.servo.set_temperature(81);
  bench.run(0.01);
  EXPECT_EQ(bench.get(xm::kHardwareErrorStatus), xm::kErrorOverheat);
  EXPECT_EQ(bench.get(xm::kTorqueEnable), 0);
  EXPECT_TRUE(bench.servo.alert());
  EXPECT_FALSE(bench.drive.powered);
  EXPECT_EQ(bench.try_set(xm::kTorqueEnable, 1), StatusError::result_fail);
  bench.servo.set_temperature(40);
  bench.servo.reboot(bench.now);
  bench.run(1.1);
  EXPECT_EQ(bench.get(xm::kHardwareErrorStatus), 0);
  EXPECT_EQ(bench.try_set(xm::kTorqueEnable, 1), StatusError::none);
}

TEST(Servo, StalledMotorHeatsAndTripsTheOverload) {
  Bench bench;
  bench.hand = true;
  bench.set(xm::kTorqueEnable, 1);
  bench.set(xm::kGoalPosition, 4000);
  const double before = bench.servo.temperature_C();
  bench.run(1.5);
  EXPECT_EQ(bench.get(xm::kHardwareErrorStatus), 0);
  EXPECT_GT(bench.servo.temperature_C(), before + 0.5);  // 27 W into 45 J/K
  bench.run(1.0);
  EXPECT_EQ(bench.get(xm::kHardwareErrorStatus), xm::kErrorOverload);
  EXPECT_EQ(bench.get(xm::kTorqueEnable), 0);
}

TEST(Servo, ErrorOutsideTheShutdownMaskOnlyAlerts) {
  Bench bench;
  bench.set(xm::kTorqueEnable, 1);
  bench.supply = 9.0;  // below the limit of 9.5 V
  bench.run(0.01);
  EXPECT_EQ(bench.get(xm::kHardwareErrorStatus), xm::kErrorVoltage);
  EXPECT_EQ(bench.get(xm::kTorqueEnable), 1);
}

TEST(Servo, BrownOutLosesRam) {
  Bench bench;
  bench.set(xm::kTorqueEnable, 1);
  bench.supply = 6.0;
  bench.run(0.1);
  EXPECT_FALSE(bench.servo.listening());
  EXPECT_FALSE(bench.drive.powered);
  bench.supply = 12.0;
  bench.run(1.1);
  EXPECT_TRUE(bench.servo.listening());
  EXPECT_EQ(bench.get(xm::kPositionPGain), 800);
}

TEST(Servo, BusWatchdogStopsAtTheSilenceItWasToldOf) {
  Bench bench;
  bench.hand = true;
  bench.set(xm::kTorqueEnable, 1);
  bench.set(xm::kGoalPosition, 2500);
  bench.set(xm::kBusWatchdog, 5);  // 100 ms
  bench.servo.heard(bench.now);
  bench.run(0.09);
  EXPECT_EQ(bench.get(xm::kBusWatchdog), 5);
  bench.run(0.02);
  EXPECT_EQ(bench.get(xm::kBusWatchdog), -1);
  EXPECT_EQ(bench.get(xm::kGoalPosition), bench.get(xm::kPresentPosition));
  EXPECT_EQ(bench.get(xm::kTorqueEnable), 1);
  EXPECT_EQ(bench.try_set(xm::kGoalPosition, 2500), StatusError::data_range);
  bench.set(xm::kBusWatchdog, 0);
  EXPECT_EQ(bench.try_set(xm::kGoalPosition, 2500), StatusError::none);
}

TEST(Servo, ChangeOfModeResetsGains) {
  Bench bench;
  bench.set(xm::kOperatingMode, 3);
  EXPECT_EQ(bench.get(xm::kPositionPGain), 800);
}

}  // namespace
}  // namespace sanso::emulator
