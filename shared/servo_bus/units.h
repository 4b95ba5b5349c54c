// Raw servo counts to SI and back. The only place where a raw unit has a factor.
// Source: ROBOTIS e-Manual, XM430-W350, control table and data sheet.
#pragma once

#include <cmath>
#include <cstdint>

namespace sanso::servo_bus {

inline constexpr double kRadPerCount = 2.0 * 3.14159265358979323846 / 4096.0;  // 0.087890625 deg
// count of joint angle 0
inline constexpr std::int32_t kCenter_raw = 2048;
inline constexpr double kRadPerSecondPerCount = 0.229 * 2.0 * 3.14159265358979323846 / 60.0;
inline constexpr double kAmperePerCount = 2.69e-3;
inline constexpr double kVoltPerCount = 0.1;
inline constexpr int kFullPwm_raw = 885;  // duty 1
inline constexpr double kSecondPerReturnDelay = 2e-6;
inline constexpr double kSecondPerWatchdog = 20e-3;

constexpr double position_rad(std::int32_t raw) { return (raw - kCenter_raw) * kRadPerCount; }
inline std::int32_t position_raw(double rad) {
  return kCenter_raw + static_cast<std::int32_t>(std::lround(rad / kRadPerCount));
}

constexpr double velocity_rad_s(std::int32_t raw) { return raw * kRadPerSecondPerCount; }
inline std::int32_t velocity_raw(double rad_s) {
  return static_cast<std::int32_t>(std::lround(rad_s / kRadPerSecondPerCount));
}

constexpr double current_A(std::int16_t raw) { return raw * kAmperePerCount; }
inline std::int16_t current_raw(double ampere) {
  return static_cast<std::int16_t>(std::lround(ampere / kAmperePerCount));
}

constexpr double duty(std::int16_t pwm_raw) { return static_cast<double>(pwm_raw) / kFullPwm_raw; }
inline std::int16_t pwm_raw(double duty_cycle) {
  return static_cast<std::int16_t>(std::lround(duty_cycle * kFullPwm_raw));
}

constexpr double voltage_V(std::uint16_t raw) { return raw * kVoltPerCount; }
inline std::uint16_t voltage_raw(double volt) {
  return static_cast<std::uint16_t>(std::lround(volt / kVoltPerCount));
}

}  // namespace sanso::servo_bus
