// One update: goals that are due, profile, position loop, what the sensors publish, rules of
// shutdown.
#include "tools/emulator/servo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "shared/servo_bus/units.h"

namespace sanso::emulator {
namespace {

namespace xm = servo_bus::xm430;
using servo_bus::StatusError;

// "roughly a second" of silence after a reboot
constexpr Nanoseconds kRebootTime = 1 * kSecond;
constexpr Nanoseconds kPowerOnTime = 300 * kMillisecond;  // chosen
// measured on sibling servos: 30 to 50 us over the register
constexpr Nanoseconds kReplyLatency = 30 * kMicrosecond;
constexpr double kUnderVoltage_V = 7.0;  // the servo's own regulator gives up
constexpr double kAmbient_C = 25.0;
constexpr double kHeatCapacity_J_K = 45.0;  // 82 g of motor, gears and case
constexpr double kHeatResistance_K_W = 9.0;
constexpr double kStandBy_W = 0.5;          // 40 mA at 12 V
constexpr double kOverloadCurrent_A = 1.7;  // about three quarters of stall at 12 V
constexpr double kOverloadTime_s = 2.0;
constexpr std::int64_t kModePwm = 16;

/// Settings of which only one value is emulated: others are refused, never taken without effect.
struct OnlyValue {
  const servo_bus::Register* setting;
  std::int64_t allowed_raw;
};
constexpr std::array kOnlyValue{OnlyValue{&xm::kDriveMode, 0},
                                OnlyValue{&xm::kSecondaryId, 255},
                                OnlyValue{&xm::kProtocolType, 2},
                                OnlyValue{&xm::kHomingOffset, 0},
                                OnlyValue{&xm::kStartupConfiguration, 0},
                                OnlyValue{&xm::kFeedforwardAccelerationGain, 0},
                                OnlyValue{&xm::kFeedforwardVelocityGain, 0}};

}  // namespace

Servo::Servo(std::uint8_t id, const plant::ServoParameters& parameters, std::int64_t baud)
    : id_(id), parameters_(parameters), line_baud_(baud) {
  const auto rate = std::find(xm::kBaudRates.begin(), xm::kBaudRates.end(), baud);
  if (rate == xm::kBaudRates.end())
    throw std::invalid_argument("no servo talks at " + std::to_string(baud) + " baud");
  registers_.set(xm::kId, id);
  registers_.set(xm::kFirmwareVersion, xm::kFirmwareWithFastRead);
  registers_.set(xm::kBaudRate, rate - xm::kBaudRates.begin());
  registers_.set(xm::kReturnDelayTime, 1);  // 2 us, as the maker sets up an OP3
}

std::int64_t Servo::own_baud() const {
  return xm::kBaudRates[static_cast<std::size_t>(registers_.get(xm::kBaudRate))];
}

void Servo::boot(Nanoseconds now, Nanoseconds duration) {
  const std::int64_t id = registers_.get(xm::kId);
  registers_.load_defaults(false);
  registers_.set(xm::kId, id);
  registers_.set(xm::kFirmwareVersion, firmware_);
  registers_.set(xm::kGoalPosition, position_raw_);
  registers_.set(xm::kGoalPwm, registers_.get(xm::kPwmLimit));
  booting_ = true;
  boot_done_ = now + duration;
  goal_raw_ = position_raw_;
  trajectory_raw_ = position_raw_;
  trajectory_rate_raw_ = integral_raw_ = overload_s_ = 0;
  due_goals_.clear();
  held_.clear();
  last_heard_ = now;
}

void Servo::set_firmware(std::uint8_t version) {
  firmware_ = version;
  registers_.set(xm::kFirmwareVersion, version);
}

void Servo::reboot(Nanoseconds now) { boot(now, kRebootTime); }

void Servo::set_power(bool on, Nanoseconds now) {
  if (on && !powered_) boot(now, kPowerOnTime);
  if (!on && powered_) registers_.set(xm::kTorqueEnable, 0);
  powered_ = on;
}

void Servo::raise(std::uint8_t error_bits) {
  const auto status = registers_.get(xm::kHardwareErrorStatus) | error_bits;
  registers_.set(xm::kHardwareErrorStatus, status);
  if (status & registers_.get(xm::kShutdown)) registers_.set(xm::kTorqueEnable, 0);
}

ServoDrive Servo::update(Nanoseconds now, double period_s, const ServoSense& sense) {
  position_raw_ = servo_bus::position_raw(sense.position_rad);
  // stays in boot while the supply is low
  if (powered_ && sense.supply_V < kUnderVoltage_V) boot(now, kPowerOnTime);
  if (booting_ && now >= boot_done_) {
    booting_ = false;
    if (std::exchange(shut_down_once_, false)) raise(xm::kErrorOverload);
  }
  if (!powered_ || booting_) return {};

  publish(now, sense, position_raw_);
  watch(period_s, sense);
  check_bus_watchdog(now);
  take_due_goals(now);
  follow_profile(period_s);

  int pwm = 0;
  const bool torque = torque_on();
  if (torque) {
    pwm = registers_.get(xm::kOperatingMode) == xm::kModePosition
              ? position_loop_pwm(position_raw_)
              : static_cast<int>(registers_.get(xm::kGoalPwm));
    const int limit = static_cast<int>(
        std::min(std::abs(registers_.get(xm::kGoalPwm)), registers_.get(xm::kPwmLimit)));
    pwm = std::clamp(pwm, -limit, limit);
  } else {
    integral_raw_ = 0;
    trajectory_raw_ = position_raw_;
    trajectory_rate_raw_ = 0;
  }
  registers_.set(xm::kPresentPwm, pwm);
  return {torque, static_cast<double>(pwm) / servo_bus::kFullPwm_raw};
}

/// PWM counts from position counts: P, I and D of the error, as the control table scales them.
int Servo::position_loop_pwm(std::int32_t position_raw) {
  const std::int32_t error_raw =
      static_cast<std::int32_t>(std::lround(trajectory_raw_)) - position_raw;
  const double p = static_cast<double>(registers_.get(xm::kPositionPGain)) / parameters_.p_divisor;
  const double d = static_cast<double>(registers_.get(xm::kPositionDGain)) / 16.0;
  const double i = static_cast<double>(registers_.get(xm::kPositionIGain)) / 65536.0;
  if (i > 0) {
    // anti-windup: the integral alone may ask for full duty
    const double limit = servo_bus::kFullPwm_raw / i;
    integral_raw_ = std::clamp(integral_raw_ + error_raw, -limit, limit);
  } else {
    integral_raw_ = 0;
  }
  const double pwm = p * error_raw + i * integral_raw_ + d * (error_raw - last_error_raw_);
  last_error_raw_ = error_raw;
  return static_cast<int>(std::lround(std::clamp(pwm, -1e6, 1e6)));
}

void Servo::take_due_goals(Nanoseconds now) {
  while (!due_goals_.empty() && due_goals_.front().time <= now) {
    goal_raw_ = due_goals_.front().goal_raw;
    due_goals_.pop_front();
  }
}

/// Trapezoidal speed towards the goal; Profile Velocity 0 passes steps straight through.
void Servo::follow_profile(double period_s) {
  const double speed = static_cast<double>(registers_.get(xm::kProfileVelocity)) *
                       servo_bus::kRadPerSecondPerCount / servo_bus::kRadPerCount;
  if (speed == 0) {
    trajectory_raw_ = goal_raw_;
    trajectory_rate_raw_ = 0;
    return;
  }
  // 214.577 rev/min^2 a count
  const double acceleration =
      static_cast<double>(registers_.get(xm::kProfileAcceleration)) * 214.577 * 4096 / 3600;
  const double distance = goal_raw_ - trajectory_raw_;
  double wanted = std::copysign(speed, distance);
  if (acceleration > 0) {
    wanted =
        std::copysign(std::min(speed, std::sqrt(2 * acceleration * std::abs(distance))), distance);
    const double change = acceleration * period_s;
    wanted = std::clamp(wanted, trajectory_rate_raw_ - change, trajectory_rate_raw_ + change);
  }
  if (std::abs(wanted * period_s) >= std::abs(distance) && wanted * distance >= 0) {
    trajectory_raw_ = goal_raw_;
    trajectory_rate_raw_ = 0;
  } else {
    trajectory_raw_ += wanted * period_s;
    trajectory_rate_raw_ = wanted;
  }
}

/// Present values reach the registers with the sensor delay.
void Servo::publish(Nanoseconds now, const ServoSense& sense, std::int32_t position_raw) {
  const double blend = std::min(1.0, parameters_.loop_period_s / parameters_.velocity_filter_s);
  filtered_rate_ += blend * (sense.velocity_rad_s - filtered_rate_);
  samples_.push_back({now, position_raw, filtered_rate_, sense.current_A});
  const Nanoseconds due = now - from_seconds(parameters_.sensor_delay_s);
  while (samples_.size() > 1 && samples_[1].time <= due) samples_.pop_front();
  const Sample& seen = samples_.front();
  registers_.set(xm::kPresentPosition, seen.position_raw);
  registers_.set(xm::kPresentVelocity, servo_bus::velocity_raw(seen.velocity_rad_s));
  registers_.set(xm::kPresentCurrent,
                 std::clamp<int>(servo_bus::current_raw(seen.current_A), -1193, 1193));
  registers_.set(xm::kPresentInputVoltage, servo_bus::voltage_raw(sense.supply_V));
  registers_.set(xm::kPresentTemperature, std::lround(temperature_C_));
  registers_.set(xm::kRealtimeTick, (now / kMillisecond) & 0x7fff);
  registers_.set(xm::kPositionTrajectory, std::lround(trajectory_raw_));
  registers_.set(xm::kVelocityTrajectory,
                 std::lround(trajectory_rate_raw_ * servo_bus::kRadPerCount /
                             servo_bus::kRadPerSecondPerCount));
  registers_.set(xm::kMoving, std::abs(servo_bus::velocity_raw(filtered_rate_)) >=
                                  registers_.get(xm::kMovingThreshold));
  registers_.set(xm::kMovingStatus, std::abs(goal_raw_ - position_raw) < 10 ? 1 : 0);
  registers_.set(xm::kRegisteredInstruction, held_.empty() ? 0 : 1);
}

double Servo::cooled(double celsius, double seconds) {
  constexpr double kIdle_C = kAmbient_C + kHeatResistance_K_W * kStandBy_W;
  return kIdle_C +
         (celsius - kIdle_C) * std::exp(-seconds / (kHeatCapacity_J_K * kHeatResistance_K_W));
}

/// Heat, overload, supply: the conditions of Hardware Error Status.
void Servo::watch(double period_s, const ServoSense& sense) {
  const double heat_W = sense.current_A * sense.current_A * parameters_.resistance_ohm + kStandBy_W;
  temperature_C_ +=
      period_s / kHeatCapacity_J_K * (heat_W - (temperature_C_ - kAmbient_C) / kHeatResistance_K_W);
  const bool heavy = std::abs(sense.current_A) > kOverloadCurrent_A;
  overload_s_ = std::max(0.0, overload_s_ + (heavy ? period_s : -period_s));

  std::uint8_t errors = 0;
  if (temperature_C_ > static_cast<double>(registers_.get(xm::kTemperatureLimit)))
    errors |= xm::kErrorOverheat;
  if (overload_s_ > kOverloadTime_s) errors |= xm::kErrorOverload;
  const auto voltage_raw = servo_bus::voltage_raw(sense.supply_V);
  if (voltage_raw < registers_.get(xm::kMinVoltageLimit) ||
      voltage_raw > registers_.get(xm::kMaxVoltageLimit)) {
    errors |= xm::kErrorVoltage;
  }
  if (errors) raise(errors);
}

/// Silence on the bus while torque is on: stop where the servo is, and refuse goals until the
/// watchdog is cleared.
void Servo::check_bus_watchdog(Nanoseconds now) {
  const std::int64_t armed = registers_.get(xm::kBusWatchdog);
  if (armed <= 0 || !torque_on()) return;
  if (now - last_heard_ <= armed * from_seconds(servo_bus::kSecondPerWatchdog)) return;
  registers_.set(xm::kBusWatchdog, -1);
  due_goals_.clear();
  goal_raw_ = std::clamp<std::int32_t>(position_raw_, 0, 4095);
  registers_.set(xm::kGoalPosition, goal_raw_);
}

Nanoseconds Servo::return_delay() const {
  return registers_.get(xm::kReturnDelayTime) * from_seconds(servo_bus::kSecondPerReturnDelay) +
         kReplyLatency;
}

int Servo::status_return_level() const {
  return static_cast<int>(registers_.get(xm::kStatusReturnLevel));
}
bool Servo::alert() const { return registers_.get(xm::kHardwareErrorStatus) != 0; }

StatusError Servo::read(std::uint16_t address, std::span<std::uint8_t> out) const {
  return registers_.read(address, out);
}

StatusError Servo::write(std::uint16_t address, std::span<const std::uint8_t> data,
                         Nanoseconds now) {
  const RegisterFile before = registers_;
  RegisterFile::Touched touched;
  const StatusError error = registers_.write(address, data, touched);
  if (error != StatusError::none) return error;
  for (const auto* r : touched) {
    const StatusError refused = refusal_of(*r, before);
    if (refused != StatusError::none) {
      registers_ = before;
      return refused;
    }
  }
  for (const auto* r : touched) after_write(*r, now);
  return StatusError::none;
}

/// What the register file cannot know: rules between registers, and what this emulation does not
/// have.
StatusError Servo::refusal_of(const servo_bus::Register& r, const RegisterFile& before) const {
  const std::int64_t value = registers_.get(r);
  const auto is = [&](const servo_bus::Register& other) { return r.address == other.address; };
  for (const auto& [only, allowed] : kOnlyValue) {
    if (is(*only) && value != allowed) return StatusError::data_range;
  }
  if (is(xm::kOperatingMode) && value != xm::kModePosition && value != kModePwm)
    return StatusError::data_range;
  const bool shut_down =
      (registers_.get(xm::kHardwareErrorStatus) & registers_.get(xm::kShutdown)) != 0;
  if (is(xm::kTorqueEnable) && value != 0 && shut_down) return StatusError::result_fail;
  if (is(xm::kGoalPosition)) {
    if (before.get(xm::kBusWatchdog) < 0) return StatusError::data_range;
    const bool inside = value >= registers_.get(xm::kMinPositionLimit) &&
                        value <= registers_.get(xm::kMaxPositionLimit);
    if (!inside) return StatusError::data_limit;
  }
  if (is(xm::kGoalPwm) && std::abs(value) > registers_.get(xm::kPwmLimit))
    return StatusError::data_limit;
  return StatusError::none;
}

void Servo::after_write(const servo_bus::Register& r, Nanoseconds now) {
  if (r.address == xm::kGoalPosition.address) {
    const auto goal_raw = static_cast<std::int32_t>(registers_.get(xm::kGoalPosition));
    due_goals_.push_back({now + from_seconds(parameters_.command_delay_s), goal_raw});
  } else if (r.address == xm::kOperatingMode.address) {
    // a change of mode puts that mode's gains and limits back to their defaults
    for (const auto* reset : {&xm::kPositionPGain, &xm::kPositionIGain, &xm::kPositionDGain,
                              &xm::kProfileVelocity, &xm::kProfileAcceleration}) {
      registers_.set(*reset, reset->initial_raw);
    }
    registers_.set(xm::kGoalPwm, registers_.get(xm::kPwmLimit));
  } else if (r.address == xm::kId.address) {
    id_ = static_cast<std::uint8_t>(registers_.get(xm::kId));
  } else if (r.address == xm::kTorqueEnable.address && torque_on()) {
    last_error_raw_ = 0;
    last_heard_ = now;
  }
}

void Servo::hold_write(HeldWrite write) { held_.push_back(std::move(write)); }

StatusError Servo::run_held_write(Nanoseconds now) {
  if (held_.empty()) return StatusError::result_fail;
  StatusError result = StatusError::none;
  for (const HeldWrite& held : std::exchange(held_, {})) {
    const StatusError error = write(held.address, held.data, now);
    if (error != StatusError::none) result = error;
  }
  return result;
}

}  // namespace sanso::emulator
