// watch() asks one subject after the other, and the first fault of a tick stays; limit() clips a
// target and reports each clip.
#include "firmware/guard/guard.h"

#include <algorithm>
#include <cmath>

#include "shared/model/joints.h"
#include "shared/servo_bus/units.h"
#include "shared/servo_bus/xm430.h"

namespace sanso::firmware {
namespace {

constexpr double kTick_s = to_seconds(kTickPeriod);

/// The first fault of a tick stays: it is checked in the order of how directly it names a cause.
void raise(GuardVerdict& verdict, Fault fault, std::uint16_t detail = 0) {
  if (verdict.fault != Fault::none) return;
  verdict.fault = fault;
  verdict.detail = detail;
}

int ticks_of(double seconds) {
  return std::max(1, static_cast<int>(std::lround(seconds / kTick_s)));
}

}  // namespace

void Guard::reset() {
  fall_ticks_ = low_voltage_ticks_ = high_voltage_ticks_ = 0;
  imu_changed_ = 0;
}

GuardVerdict Guard::watch(const GuardSituation& s, const ServoReadings& servos,
                          const ImuSample& imu) {
  GuardVerdict verdict;
  watch_bus(servos, verdict);
  watch_servos(s, servos, verdict);
  watch_supply(servos, verdict);
  watch_imu(s, imu, verdict);
  watch_body(s, verdict);
  verdict.limits.add_if(s.late_in_a_row > 0, Limit::late_tick);
  if (s.late_in_a_row >= settings_.overrun_ticks)
    raise(verdict, Fault::tick_overrun, static_cast<std::uint16_t>(s.late_in_a_row));
  return verdict;
}

void Guard::watch_bus(const ServoReadings& servos, GuardVerdict& verdict) const {
  if (servos.port_gone) raise(verdict, Fault::bus_gone);
  verdict.limits.add_if(servos.answered < servos.asked, Limit::bus_loss);
  int silent = 0;
  std::uint16_t first_silent = 0;
  for (std::size_t j = 0; j < model::kNumJoints; ++j) {
    if (servos.servo[j].age_ticks < bus_.silent_ticks) continue;
    if (silent++ == 0) first_silent = kServoIds[j];
  }
  if (silent == model::kNumJoints)
    raise(verdict, Fault::bus_silent);
  else if (silent > 0)
    raise(verdict, Fault::servo_silent, first_silent);
}

void Guard::watch_servos(const GuardSituation& s, const ServoReadings& servos,
                         GuardVerdict& verdict) {
  for (std::size_t k = 0; k < kNumServos; ++k) {
    const ServoHealth& health = servos.health[k];
    const std::uint16_t id = kServoIds[k];
    const std::uint8_t error = health.hardware_error;
    namespace xm430 = servo_bus::xm430;
    verdict.limits.add_if(health.temperature_C >= settings_.warm_temperature_C, Limit::temperature);
    if ((error & xm430::kErrorOverheat) != 0 || health.temperature_C >= settings_.max_temperature_C)
      raise(verdict, Fault::over_temperature, id);
    if ((error & xm430::kErrorOverload) != 0) raise(verdict, Fault::overload, id);
    if ((error & (xm430::kErrorEncoder | xm430::kErrorShock)) != 0)
      raise(verdict, Fault::servo_hardware, id);
    verdict.limits.add_if((error & xm430::kErrorVoltage) != 0, Limit::voltage);
    if (s.torque_expected && health.torque_known && !health.torque_on)
      raise(verdict, Fault::torque_lost, id);
  }
  for (std::size_t j = 0; j < model::kNumJoints; ++j)
    verdict.limits.add_if(
        std::abs(servo_bus::current_A(servos.servo[j].current_raw)) > settings_.max_current_A,
        Limit::current);
}

void Guard::watch_supply(const ServoReadings& servos, GuardVerdict& verdict) {
  float lowest = 1e9f, highest = 0;
  for (const ServoHealth& health : servos.health) {
    if (health.voltage_V <= 0) continue;
    lowest = std::min(lowest, health.voltage_V);
    highest = std::max(highest, health.voltage_V);
  }
  if (highest == 0) return;
  verdict.limits.add_if(lowest < settings_.low_voltage_V, Limit::voltage);
  low_voltage_ticks_ = lowest < settings_.min_voltage_V ? low_voltage_ticks_ + 1 : 0;
  high_voltage_ticks_ = highest > settings_.max_voltage_V ? high_voltage_ticks_ + 1 : 0;
  const auto decivolt = [](float v) { return static_cast<std::uint16_t>(std::lround(10 * v)); };
  if (low_voltage_ticks_ >= ticks_of(settings_.voltage_time_s))
    raise(verdict, Fault::under_voltage, decivolt(lowest));
  if (high_voltage_ticks_ >= ticks_of(settings_.voltage_time_s))
    raise(verdict, Fault::over_voltage, decivolt(highest));
}

void Guard::watch_imu(const GuardSituation& s, const ImuSample& imu, GuardVerdict& verdict) {
  if (imu_changed_ == 0 || imu.changes != imu_changes_) {
    imu_changes_ = imu.changes;
    imu_changed_ = s.now;
  }
  const Nanoseconds age = s.now - imu.time;
  verdict.limits.add_if(age > from_seconds(imu_.late_s), Limit::imu_late);
  if (age > from_seconds(imu_.silent_s))
    raise(verdict, Fault::imu_silent);
  else if (s.now - imu_changed_ > from_seconds(imu_.frozen_s))
    raise(verdict, Fault::imu_frozen);
}

void Guard::watch_body(const GuardSituation& s, GuardVerdict& verdict) {
  verdict.limits.add_if(s.tilt > settings_.tilt_limit_rad, Limit::tilt);
  if (!s.estimate_healthy) raise(verdict, Fault::estimate);
  const bool falling =
      s.standing && (s.tilt > settings_.fall_tilt_rad || s.height < settings_.fall_height_m);
  fall_ticks_ = falling ? fall_ticks_ + 1 : 0;
  if (fall_ticks_ >= ticks_of(settings_.fall_time_s))
    raise(verdict, Fault::fallen, static_cast<std::uint16_t>(1000 * s.tilt));
}

model::Input Guard::limit(const model::Input& wanted, const model::Input& previous,
                          const model::Input& q, LimitSet& limits) const {
  const double step = settings_.max_target_rate_rad_s * kTick_s;
  model::Input out;
  for (int j = 0; j < model::kNumJoints; ++j) {
    const model::JointInfo& joint = model::kJoints[static_cast<std::size_t>(j)];
    double u = std::isfinite(wanted[j]) ? wanted[j] : previous[j];
    const auto bound = [&](double low, double high, Limit which) {
      const double inside = std::clamp(u, low, high);
      limits.add_if(inside != u, which);
      u = inside;
    };
    // order matters: the range comes last, so that nothing can push a target out of it again
    bound(previous[j] - step, previous[j] + step, Limit::joint_rate);
    bound(q[j] - settings_.max_target_offset_rad, q[j] + settings_.max_target_offset_rad,
          Limit::servo_torque);
    bound(joint.lower_rad + settings_.joint_margin_rad,
          joint.upper_rad - settings_.joint_margin_rad, Limit::joint_range);
    out[j] = u;
  }
  return out;
}

}  // namespace sanso::firmware
