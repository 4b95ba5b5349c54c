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

// a joint found outside its range comes in this fast
constexpr double kComeIn_rad_s = 0.5;

/// The first fault of a tick stays: it is checked in the order of how directly it names a cause.
void raise(GuardVerdict& verdict, Fault fault, std::uint16_t detail = 0) {
  verdict.fallen = verdict.fallen || fault == Fault::fallen;
  verdict.must_lower = verdict.must_lower || reaction_of(fault) == FaultReaction::lower;
  if (verdict.fault != Fault::none) return;
  verdict.fault = fault;
  verdict.detail = detail;
}

int ticks_of(double seconds) {
  return std::max(1, static_cast<int>(std::lround(seconds / kTick_s)));
}

}  // namespace

void Guard::reset() {
  fall_ticks_ = 0;
  low_since_ = high_since_ = imu_changed_ = 0;
  late_.reset();
}

GuardVerdict Guard::watch(const GuardSituation& s, const ServoReadings& servos,
                          const ImuSample& imu) {
  GuardVerdict verdict;
  watch_bus(s, servos, verdict);
  watch_servos(s, servos, verdict);
  watch_supply(s.now, servos, verdict);
  watch_imu(s, imu, verdict);
  watch_body(s, verdict);
  watch_lateness(s.late, verdict);
  return verdict;
}

void Guard::watch_lateness(bool late, GuardVerdict& verdict) {
  late_[late_next_] = late;
  late_next_ = (late_next_ + 1) % late_.size();
  verdict.limits.add_if(late, Limit::late_tick);
  if (late_.count() >= static_cast<std::size_t>(settings_.overrun_ticks))
    raise(verdict, Fault::tick_overrun, static_cast<std::uint16_t>(late_.count()));
}

void Guard::watch_bus(const GuardSituation& s, const ServoReadings& servos,
                      GuardVerdict& verdict) const {
  if (servos.port_gone) raise(verdict, Fault::bus_gone);
  if (s.bus_foreign) raise(verdict, Fault::bus_foreign);
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
  for (std::size_t k = model::kNumJoints; k < kNumServos && s.watch_held; ++k)
    if (servos.servo[k].age_ticks >= bus_.silent_ticks)
      raise(verdict, Fault::servo_silent, kServoIds[k]);
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

/// A supply is out of limits when every new reading says so for long enough, whichever servo gave
/// it: an old number is not looked at twice.
void Guard::watch_supply(Nanoseconds now, const ServoReadings& servos, GuardVerdict& verdict) {
  float lowest = 1e9f, highest = 0;
  float newest = 0;
  for (std::size_t k = 0; k < kNumServos; ++k) {
    const ServoHealth& health = servos.health[k];
    if (health.supply_reads != seen_reads_[k]) newest = health.voltage_V;
    seen_reads_[k] = health.supply_reads;
    if (health.voltage_V <= 0) continue;
    lowest = std::min(lowest, health.voltage_V);
    highest = std::max(highest, health.voltage_V);
  }
  if (highest == 0) return;
  verdict.limits.add_if(lowest < settings_.low_voltage_V, Limit::voltage);
  if (newest <= 0) return;
  const auto since = [&](bool outside, Nanoseconds& begin) {
    if (!outside) begin = 0;
    if (outside && begin == 0) begin = now;
    return outside && now - begin >= from_seconds(settings_.voltage_time_s);
  };
  const auto decivolt = static_cast<std::uint16_t>(std::lround(10 * newest));
  if (since(newest < settings_.min_voltage_V, low_since_))
    raise(verdict, Fault::under_voltage, decivolt);
  if (since(newest > settings_.max_voltage_V, high_since_))
    raise(verdict, Fault::over_voltage, decivolt);
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
  else if (s.imu_reason != 0)
    raise(verdict, Fault::imu_implausible, s.imu_reason);
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
  model::Input out;
  for (int j = 0; j < model::kNumJoints; ++j) {
    const model::JointInfo& joint = model::kJoints[static_cast<std::size_t>(j)];
    const double low = joint.lower_rad + settings_.joint_margin_rad;
    const double high = joint.upper_rad - settings_.joint_margin_rad;
    // nothing to start from: where the joint is, or the nearest that it may be
    const double from = std::isfinite(previous[j])
                            ? previous[j]
                            : std::clamp(std::isfinite(q[j]) ? q[j] : 0.0, low, high);
    double u = std::isfinite(wanted[j]) ? wanted[j] : from;
    const auto bound = [&](double least, double most, Limit which) {
      const double inside = std::clamp(u, least, most);
      limits.add_if(inside != u, which);
      u = inside;
    };
    const double offset = settings_.max_target_offset_rad;
    if (std::isfinite(q[j])) bound(q[j] - offset, q[j] + offset, Limit::servo_torque);
    bound(low, high, Limit::joint_range);
    // the rate comes last: whatever the reading and the range say, a target never steps
    const bool outside = from < low || from > high;
    const double step = kTick_s * (outside ? kComeIn_rad_s : settings_.max_target_rate_rad_s);
    bound(from - step, from + step, Limit::joint_rate);
    out[j] = u;
  }
  return out;
}

std::array<double, kNumHeld> Guard::limit_held(const std::array<double, kNumHeld>& wanted,
                                               const std::array<double, kNumHeld>& previous,
                                               LimitSet& limits) const {
  const double step = kTick_s * settings_.max_held_rate_rad_s;
  std::array<double, kNumHeld> out{};
  for (std::size_t k = 0; k < kNumHeld; ++k) {
    const double from = std::isfinite(previous[k]) ? previous[k] : 0.0;
    const double goal = std::isfinite(wanted[k]) ? wanted[k] : from;
    const double inside = std::clamp(goal, -kHeldRange_rad, kHeldRange_rad);
    out[k] = std::clamp(inside, from - step, from + step);
    limits.add_if(inside != goal, Limit::joint_range);
    limits.add_if(out[k] != inside, Limit::joint_rate);
  }
  return out;
}

double Guard::allowed_duty(double temperature_C) const {
  const double warm = settings_.warm_temperature_C, hot = settings_.max_temperature_C;
  const double heat = std::clamp((temperature_C - warm) / std::max(hot - warm, 1.0), 0.0, 1.0);
  const double least = std::min(settings_.hot_duty, settings_.max_duty);
  return settings_.max_duty + heat * (least - settings_.max_duty);
}

}  // namespace sanso::firmware
