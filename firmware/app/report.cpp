// What a tick publishes: the observation for the hosts, the record for the log.
#include <algorithm>

#include "firmware/app/controller.h"

namespace sanso::firmware {

void Controller::publish(Nanoseconds now, Nanoseconds cpu_begin) {
  wire::Observation& o = observation_;
  const ImuSample& imu = handover_.imu.front();
  ++o.tick;
  o.time = now;
  o.trial_tick = supervisor_.state() == SupervisorState::run ? trial_.tick() : -1;
  o.trial_id = trial_.id();
  o.state = supervisor_.state();
  o.fault = static_cast<std::uint16_t>(supervisor_.fault());
  o.contact = estimator_.contact_bits();
  o.pose_age_ticks = estimator_.pose_age_ticks();
  o.x = x_;
  for (std::size_t j = 0; j < model::kNumJoints; ++j) {
    o.current_raw[j] = servos_.servo[j].current_raw;
    record_.position_raw[j] = servos_.servo[j].position_raw;
  }
  for (int a = 0; a < 3; ++a) {
    o.imu_acc[static_cast<std::size_t>(a)] = imu.accel[a];
    o.imu_gyro[static_cast<std::size_t>(a)] = imu.gyro[a];
  }
  report_supply(o);
  report_layers(now, o);
  o.limits = verdict_.limits.bits();
  o.late_ticks = late_ticks_;
  o.bus_lost = bus_.counters().lost;
  o.bus_corrupt = bus_.counters().corrupt;
  o.datagrams_dropped =
      handover_.datagrams_dropped.load(std::memory_order_relaxed) + trial_.stale_policies();
  o.tick_cpu_ns = static_cast<std::uint32_t>(clock_.thread_cpu() - cpu_begin);
  (void)handover_.observations.push(o);
  record_.observation = o;
  record_.fault_detail = supervisor_.fault_detail();
  if (!handover_.log.push(record_)) ++record_.dropped;
  handover_.ticks.store(o.tick, std::memory_order_relaxed);
}

void Controller::report_supply(wire::Observation& o) const {
  float voltage = 0;
  o.max_temperature_C = 0;
  for (const ServoHealth& health : servos_.health) {
    if (health.voltage_V > 0)
      voltage = voltage > 0 ? std::min(voltage, health.voltage_V) : health.voltage_V;
    o.max_temperature_C = std::max(o.max_temperature_C, health.temperature_C);
  }
  o.voltage_V = voltage;
}

void Controller::report_layers(Nanoseconds now, wire::Observation& o) {
  const bool running = supervisor_.state() == SupervisorState::run;
  o.upper_sequence = trial_.upper_sequence();
  o.upper_age_ticks = trial_.upper_age_ticks();
  o.upper_weight = static_cast<float>(layers_.weight);
  o.u_upper = layers_.upper;
  o.u_middle = layers_.middle;
  o.u_lower = layers_.lower;
  o.u_out = output_;
  if (!running) return;
  const bool wanted = trial_.upper_wanted();
  verdict_.limits.add_if(wanted && !trial_.has_upper(), Limit::upper_missing);
  verdict_.limits.add_if(wanted && trial_.has_upper() && layers_.weight < 1.0, Limit::upper_stale);
  verdict_.limits.add_if(estimator_.pose_age_ticks() < 255 && estimator_.pose_age_ticks() > 10,
                         Limit::pose_stale);
  verdict_.limits.add_if(host_silent(now), Limit::host_silent);
}

}  // namespace sanso::firmware
