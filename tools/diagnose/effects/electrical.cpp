// Servo firmware and electrical supply: E1 to E11 of the method page.
#include <algorithm>

#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {

std::vector<Effect> electrical_effects() {
  constexpr Family F = Family::electrical;
  constexpr Scope S = Scope::joint;
  constexpr unsigned R = kR2 | kR4;
  return {
      {"servo_p_gain", "E1", "P gain of the servo", "p_gain (kp) times gain", F, Port::firmware, S,
       {{"gain", "-", 1, 0.4, 2.5, 0.2}},
       true, {{1.2}}, 0, R, kPositionLoop, "AH", {"torque_constant", "battery_drift", "link_mass", "supply_sag", "current_limit", "thermal_derating"},
       {"high load", "standstill", "near command step"}, "static error in proportion to load, in all regimes", {kHalveGain, kLogDuty},
       [](SimParams& p, int j, Theta x) { joint(p, j).p_scale *= x[0]; }},
      {"servo_d_gain", "E2", "D gain or output filter of the servo", "-damping dq by the servo; first order `filter` on its output", F, Port::firmware, S,
       {{"damping", "N m s/rad", 0, 0, 2, 0.1, Unit::viscous}, {"filter", "s", 0, 0, 0.03, 0.005}},
       true, {{0.1, 0}, {0, 0.005}}, 1, R, kPositionLoop, "BC", {"viscous_friction", "torque_constant", "command_delay", "sensor_delay", "joint_compliance", "servo_profile"},
       {"near command step", "high speed"}, "shows in steps", {kTorqueOff, kLogDuty, kSteps},
       [](SimParams& p, int j, Theta x) {
         joint(p, j).d_torque += x[0];
         joint(p, j).output_filter += x[1];
       }},
      {"servo_i_gain", "E3", "I gain or feed-forward of the servo", "P gain times (integral int(error) + feed_forward d goal/dt)", F, Port::firmware, S,
       {{"integral", "1/s", 0, 0, 20, 1}, {"feed_forward", "s", 0, 0, 0.1, 0.01}},
       true, {{2, 0}, {0, 0.02}}, 1, R, kPositionLoop, "", {"servo_p_gain", "coulomb_friction"}, {"standstill", "near command step"},
       "the static error decays", {kHolds, kLogDuty},
       [](SimParams& p, int j, Theta x) {
         joint(p, j).integral_rate += x[0];
         joint(p, j).feed_forward += x[1];
       }},
      {"torque_constant", "E4", "torque constant or winding resistance", "torque per current (and back-EMF) times torque, resistance times resistance", F, Port::electrical, S,
       {{"torque", "-", 1, 0.6, 1.4, 0.1}, {"resistance", "-", 1, 0.6, 1.4, 0.1}},
       true, {{1.15, 1}, {1, 1.15}}, 0, R, kCommand, "AC", {"servo_p_gain", "battery_drift", "link_mass", "viscous_friction"},
       {"high load", "high speed"}, "only their ratio, unless current or speed limits act", {kAddPayload, kLogCurrent},
       [](SimParams& p, int j, Theta x) {
         joint(p, j).torque_scale *= x[0];
         joint(p, j).resistance_scale *= x[1];
       }},
      {"voltage_limit", "E5", "limit of duty or torque, torque-speed line", "|output| <= limit of full; torque falls to zero at no_load_speed", F, Port::electrical, S,
       {{"limit", "of full", 1, 0.3, 1, 0.1}, {"no_load_speed", "rad/s", kOff, 0.5, kOff, 1, Unit::speed}},
       false, {{0.8, kOff}, {0.5, kOff}, {1, 5}}, -1, R, kCommand | kTorqueLimit, "", {"current_limit", "servo_profile"},
       {"|duty| > 0.9"}, "only near full duty", {kRaiseSupply, kLogDuty},
       [](SimParams& p, int j, Theta x) {
         joint(p, j).output_limit = std::min(joint(p, j).output_limit, x[0]);
         if (x[1] < kOff) joint(p, j).no_load_speed = x[1];
       }},
      {"current_limit", "E6", "current limit", "|i| <= current", F, Port::electrical, S,
       {{"current", "A", kOff, 0.1, kOff, 0.2, Unit::current}},
       false, {{1.2}, {0.5}}, -1, R, kMotorModel, "H", {"supply_sag", "servo_p_gain", "thermal_derating", "battery_drift", "voltage_limit"},
       {"|i| near limit", "high load"}, "a plateau that does not depend on speed", {kRaiseSupply, kLogCurrent},
       [](SimParams& p, int j, Theta x) { if (x[0] < kOff) joint(p, j).current_limit = std::min(joint(p, j).current_limit, x[0]); }},
      {"supply_sag", "E7", "supply sag", "V = V0 - resistance sum |i duty| over all joints", F, Port::electrical, Scope::robot,
       {{"resistance", "ohm", 0, 0, 3, 0.3}},
       true, {{0.5}}, 1, R, kMotorModel, "H", {"current_limit", "servo_p_gain", "thermal_derating", "battery_drift"},
       {"voltage low", "high load"}, "many joints loaded", {kLogVoltage, kAddPayload},
       [](SimParams& p, int, Theta x) { p.supply_resistance += x[0]; }},
      {"battery_drift", "E8", "supply level or drift", "V = V0 (1 + level + slope t/60 s)", F, Port::electrical, Scope::robot,
       {{"level", "-", 0, -0.2, 0.2, 0.05}, {"slope", "1/min", 0, -0.1, 0.1, 0.01}},
       true, {{0.05, 0}, {0, 0.02}}, 0, R, kPositionLoop, "AH", {"servo_p_gain", "torque_constant", "link_mass", "thermal_friction", "thermal_derating", "supply_sag"},
       {"late", "voltage low"}, "slow", {kLogVoltage, kRaiseSupply},
       [](SimParams& p, int, Theta x) {
         p.supply_level += x[0];
         p.supply_slope += x[1];
       }},
      {"thermal_derating", "E9", "torque lost when hot", "torque times 1 - rate (T - T0)", F, Port::electrical, S,
       {{"rate", "1/K", 0, 0, 0.05, 0.005}},
       true, {{0.01}}, 1, R, kCommand | kTemperature, "H", {"battery_drift", "supply_sag", "current_limit", "servo_p_gain"}, {"hot", "late"},
       "minutes, hot", {kWarm, kLogVoltage},
       [](SimParams& p, int j, Theta x) { joint(p, j).derating += x[0]; }},
      {"servo_deadband", "E10", "dead zone of the servo's output", "output below `zone` of full gives nothing, above it the rest", F, Port::firmware, S,
       {{"zone", "of full", 0, 0, 0.03, 0.005}},
       false, {{0.005}, {0.02}}, 1, R, kCommand | kTorqueLimit, "D", {"coulomb_friction", "backlash", "presliding_friction"},
       {"standstill", "reversal"}, "tiny errors are not corrected", {kHalveGain, kLogDuty},
       [](SimParams& p, int j, Theta x) { joint(p, j).dead_zone += x[0]; }},
      {"servo_profile", "E11", "profile inside the servo", "goal limited to speed and acceleration", F, Port::firmware, S,
       {{"speed", "rad/s", kOff, 0.2, kOff, 0.3, Unit::speed},
        {"acceleration", "rad/s^2", kOff, 1, kOff, 5, Unit::acceleration}},
       false, {{2, kOff}, {0.8, kOff}, {kOff, 20}, {kOff, 80}}, -1, R, kPositionLoop, "B",
       {"command_delay", "sensor_delay", "servo_d_gain", "joint_compliance", "voltage_limit"}, {"near command step", "high speed"},
       "triangular lag behind the goal", {kSteps},
       [](SimParams& p, int j, Theta x) {
         if (x[0] < kOff) joint(p, j).profile_speed = x[0];
         if (x[1] < kOff) joint(p, j).profile_acceleration = x[1];
       }},
  };
}

}  // namespace sanso::diagnose
