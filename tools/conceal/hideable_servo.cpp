// Servos, supply, clocks and sensors: how to hide an effect, and what the answer will say.
#include <algorithm>
#include <cmath>

#include "tools/conceal/hideable_families.h"

namespace sanso::conceal {

// Gains of the position loop and of the motor.
std::vector<Hideable> servo_gain_effects() {
  return {
      on_joint("servo_p_gain", 0.2, 0.6,
               [](JointTruth& j, double s, Random& r) {
                 const double gain = r.chance(0.6) ? 1 - s : 1 + s;
                 j.p_gain *= gain;
                 return Parameters{{"gain", gain}};
               },
               {"torque_constant", "battery_drift", "link_mass"}),
      on_joint("servo_d_gain", 0.3, 2.0,
               [](JointTruth& j, double s, Random&) {
                 j.d_gain = s * j.resistance / (j.torque_constant * j.voltage);
                 return Parameters{{"damping", s}};
               },
               {"viscous_friction"}),
      on_joint("servo_i_gain", 1.0, 15,
               [](JointTruth& j, double s, Random&) {
                 j.i_gain = s * JointTruth{}.p_gain;
                 return Parameters{{"integral", s}};
               }),
      on_joint("torque_constant", 0.2, 0.4,
               [](JointTruth& j, double s, Random& r) {
                 const double scale = 1 + s * sign(r);
                 j.torque_constant *= scale;
                 j.back_emf *= scale;
                 return Parameters{{"torque", scale}};
               },
               {"servo_p_gain", "battery_drift", "link_mass"}),
  };
}

// What limits the servo, and what feeds it.
std::vector<Hideable> limit_and_supply_effects() {
  return {
      on_joint("voltage_limit", 0.3, 0.85,
               [](JointTruth& j, double s, Random&) {
                 j.duty_limit = 1 - s;
                 return Parameters{{"limit", 1 - s}};
               }),
      on_joint("current_limit", 0.5, 0.95,
               [](JointTruth& j, double s, Random&) {
                 j.current_limit = 1.5 * (1 - s);
                 return Parameters{{"current", j.current_limit}};
               }),
      on_robot("supply_sag", 0.5, 3.0,
               [](WorldTruth& w, double s, Random&) {
                 w.supply_resistance = s;
                 return Parameters{{"resistance", s}};
               }),
      on_robot("battery_drift", 0.08, 0.2,
               [](WorldTruth& w, double s, Random& r) {
                 w.supply_level = -s;
                 w.supply_slope_per_min = -r.uniform(0.0, 0.5) * s;
                 return Parameters{{"level", -s}, {"slope", w.supply_slope_per_min}};
               },
               {"servo_p_gain", "torque_constant"}),
      on_joint("servo_deadband", 0.01, 0.03,
               [](JointTruth& j, double s, Random&) {
                 j.dead_zone = s;
                 return Parameters{{"zone", s}};
               }),
      on_joint("servo_profile", 0.5, 0.95,
               [](JointTruth& j, double s, Random&) {
                 j.profile_speed = 4.0 * (1 - s);
                 return Parameters{{"speed", j.profile_speed}};
               }),
  };
}

// When things happen, and what the sensors make of them.
std::vector<Hideable> clock_and_sensor_effects() {
  return {
      on_joint("command_delay", 0.015, 0.06,
               [](JointTruth& j, double s, Random&) {
                 j.command_delay_s += s;
                 return Parameters{{"delay", s}};
               },
               {"sensor_delay"}),
      on_joint("sensor_delay", 0.015, 0.06,
               [](JointTruth& j, double s, Random&) {
                 j.sensor_delay_s += s;
                 return Parameters{{"delay", s}};
               },
               {"command_delay"}),
      on_joint("sample_hold", 2, 4,
               [](JointTruth& j, double s, Random&) {
                 j.hold_cycles = std::clamp(static_cast<int>(std::lround(s)), 2, 4);
                 return Parameters{{"cycles", static_cast<double>(j.hold_cycles)}};
               }),
      on_joint("timing_jitter", 0.003, 0.008,
               [](JointTruth& j, double s, Random&) {
                 j.jitter_s = s;
                 return Parameters{{"jitter", s}};
               }),
      on_joint("packet_loss", 0.1, 0.3,
               [](JointTruth& j, double s, Random&) {
                 j.loss = s;
                 return Parameters{{"loss", s}};
               }),
      on_joint("encoder_offset", 0.03, 0.1,
               [](JointTruth& j, double s, Random& r) {
                 const double offset = s * sign(r);
                 const bool of_record = r.chance(0.5);
                 // on top of the tolerance of the zero
                 (of_record ? j.record_offset : j.offset) += offset;
                 return Parameters{{"offset", offset}, {"of_record", of_record ? 1.0 : 0.0}};
               }),
      on_joint("encoder_nonlinearity", 0.01, 0.03,
               [](JointTruth& j, double s, Random& r) {
                 const double phase = r.uniform(0, 2 * plant::kPi);
                 j.encoder_sine = s * std::sin(phase);
                 j.encoder_cosine = s * std::cos(phase);
                 return Parameters{{"sine", j.encoder_sine}, {"cosine", j.encoder_cosine}};
               }),
      on_joint("velocity_filter", 0.015, 0.05,
               [](JointTruth& j, double s, Random&) {
                 j.velocity_filter_s = s;
                 return Parameters{{"time", s}};
               }),
  };
}

}  // namespace sanso::conceal
