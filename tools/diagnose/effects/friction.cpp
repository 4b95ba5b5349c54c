// Friction: F1 to F12 of the method page.
#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {

std::vector<Effect> friction_effects() {
  constexpr Family F = Family::friction;
  constexpr Port P = Port::transmission;
  constexpr Scope S = Scope::joint;
  constexpr unsigned R = kR2 | kR3 | kR8;
  return {
      {"viscous_friction", "F1", "viscous friction", "-viscous dq", F, P, S,
       {{"viscous", "N m s/rad", 0, -1, 2, 0.1, Unit::viscous}},
       true, {{0.1}}, 0, R, 0, "C", {"servo_d_gain", "torque_constant", "air_drag"}, {"high speed", "low speed"},
       "grows with speed, dissipative", {kTorqueOff, kRaiseSupply},
       [](SimParams& p, int j, Theta x) { joint(p, j).viscous += x[0]; }},
      {"coulomb_friction", "F2", "Coulomb friction", "-coulomb sign(dq)", F, P, S,
       {{"coulomb", "N m", 0, 0, 0.6, 0.05, Unit::torque}},
       false, {{0.03}, {0.1}}, 1, R, 0, "D", {"backlash", "presliding_friction", "servo_deadband", "stribeck_friction", "load_friction"},
       {"reversal", "low speed", "standstill"}, "step at reversal, the same at all speeds", {kHalveGain, kAddPayload, kAmplitudeSweep},
       [](SimParams& p, int j, Theta x) { joint(p, j).coulomb += x[0]; }},
      {"stribeck_friction", "F3", "Stribeck friction and stiction", "-stribeck exp(-|dq/speed|^shape) sign(dq)", F, P, S,
       {{"stribeck", "N m", 0, 0, 0.6, 0.05, Unit::torque},
        {"speed", "rad/s", 0.2, 0.02, 3, 0.1, Unit::speed},
        {"shape", "-", 1, 0.5, 4, 0.5}},
       false, {{0.1, 0.1, 1}, {0.1, 0.4, 1}, {0.1, 1.2, 1}}, 1, R, 0, "D", {"coulomb_friction", "dwell_stiction"},
       {"breakaway", "low speed", "reversal"}, "sticks, then slips: shows in slow motion and at breakaway", {kSlowRamps},
       [](SimParams& p, int j, Theta x) {
         if (x[0] == 0.0) return;
         joint(p, j).stribeck += x[0];
         joint(p, j).stribeck_speed = x[1];
         joint(p, j).stribeck_shape = x[2];
       }},
      {"load_friction", "F4", "load-dependent friction", "-load |tau_motor - tau_external| sign(dq)", F, P, S,
       {{"load", "-", 0, 0, 0.5, 0.05}},
       false, {{0.05}, {0.2}}, 1, R, 0, "D", {"coulomb_friction", "directional_load_friction", "quadratic_load_friction", "gear_efficiency"},
       {"high load", "driving"}, "grows with the load the gear carries", {kAddPayload, kLiftAndLower},
       [](SimParams& p, int j, Theta x) { joint(p, j).load_friction += x[0]; }},
      {"directional_load_friction", "F5", "load friction that differs with the direction of power",
       "-|drive tau_motor - backdrive tau_external| sign(dq)", F, P, S,
       {{"drive", "-", 0, 0, 0.6, 0.05}, {"backdrive", "-", 0, 0, 0.6, 0.05}},
       false, {{0.1, 0}, {0, 0.1}}, 1, R, 0, "", {"load_friction", "gear_efficiency", "torque_constant"},
       {"driving", "back-driven"}, "driving and being driven differ", {kLiftAndLower, kAddPayload},
       [](SimParams& p, int j, Theta x) {
         joint(p, j).drive_friction += x[0];
         joint(p, j).backdrive_friction += x[1];
       }},
      {"quadratic_load_friction", "F6", "friction with the square of the load", "-quadratic (tau_motor - tau_external)^2 sign(dq)", F, P, S,
       {{"quadratic", "1/(N m)", 0, 0, 0.2, 0.02, Unit::per_torque}},
       false, {{0.05}}, 1, R, 0, "", {"load_friction"}, {"high load"}, "only under heavy load", {kAddPayload},
       [](SimParams& p, int j, Theta x) { joint(p, j).quadratic_load_friction += x[0]; }},
      {"asymmetric_friction", "F7", "friction that differs forwards and backwards",
       "-(coulomb_difference + viscous_difference |dq|) while moving, in one direction more, in the other less", F, P, S,
       {{"coulomb_difference", "N m", 0, -0.3, 0.3, 0.03, Unit::torque},
        {"viscous_difference", "N m s/rad", 0, -0.5, 0.5, 0.05, Unit::viscous}},
       false, {{0.05, 0}, {-0.05, 0}, {0, 0.1}, {0, -0.1}}, 0, R, 0, "", {"encoder_offset", "link_com", "cable_spring"},
       {"high speed", "low speed"}, "the sign of motion decides", {kTilt},
       [](SimParams& p, int j, Theta x) {
         joint(p, j).coulomb_difference += x[0];
         joint(p, j).viscous_difference += x[1];
       }},
      {"presliding_friction", "F8", "presliding friction (LuGre)", "dz = dq - |dq| z/(compliance budget), torque z/compliance + damping dz", F, P, S,
       {{"coulomb", "N m", 0, 0, 0.6, 0.05, Unit::torque},
        {"compliance", "rad/(N m)", 0, 0, 0.2, 0.01, Unit::compliance},
        {"damping", "N m s/rad", 0, 0, 1, 0.02, Unit::viscous}},
       false, {{0.05, 0.02, 0.02}, {0.05, 0.1, 0.02}}, 1, R, 0, "D", {"coulomb_friction", "joint_compliance", "backlash", "maxwell_slip_friction"},
       {"reversal", "standstill"}, "a spring below half a degree, hysteresis that does not depend on speed", {kAmplitudeSweep, kSlowRamps},
       [](SimParams& p, int j, Theta x) {
         joint(p, j).coulomb += x[0];
         joint(p, j).presliding_compliance += x[1];
         joint(p, j).presliding_damping += x[2];
       }},
      {"maxwell_slip_friction", "F9", "generalised Maxwell slip (4 elements)", "sum of 4 springs that slide at torque shares i^spread", F, P, S,
       {{"torque", "N m", 0, 0, 0.6, 0.05, Unit::torque},
        {"stiffness", "N m/rad", 50, 5, 5000, 20, Unit::stiffness},
        {"spread", "-", 1, 0, 3, 0.5}},
       false, {{0.1, 20, 1}, {0.1, 100, 1}}, 1, R, 0, "D", {"presliding_friction", "coulomb_friction"}, {"reversal", "standstill"},
       "hysteresis with non-local memory", {kAmplitudeSweep},
       [](SimParams& p, int j, Theta x) {
         if (x[0] == 0.0) return;
         joint(p, j).slip_torque += x[0];
         joint(p, j).slip_stiffness = x[1];
         joint(p, j).slip_spread = x[2];
       }},
      {"position_friction", "F10", "friction that depends on the angle", "-(sine sin(order q) + cosine cos(order q)) sign(dq)", F, P, S,
       {{"sine", "N m", 0, -0.4, 0.4, 0.05, Unit::torque},
        {"cosine", "N m", 0, -0.4, 0.4, 0.05, Unit::torque},
        {"order", "1/rad", 1, 1, 12, 1, Unit::per_angle, true}},
       false, {{0.05, 0, 1}, {0, 0.05, 1}, {0.05, 0, 2}, {0, 0.05, 2}, {0.05, 0, 4}, {0, 0.05, 4}, {0.05, 0, 8}, {0, 0.05, 8}},
       0, R, 0, "I", {"cogging", "gear_kinematic_error"}, {"low speed"}, "periodic over the angle, dissipative", {kSlowRamps, kFullRange},
       [](SimParams& p, int j, Theta x) {
         if (x[0] == 0.0 && x[1] == 0.0) return;
         joint(p, j).friction_ripple = {x[0], x[1], x[2]};
       }},
      {"thermal_friction", "F11", "friction that falls with temperature", "all friction times exp(-rate (T - T0))", F, P, S,
       {{"rate", "1/K", 0, 0, 0.05, 0.005}},
       false, {{0.01}, {0.03}}, 1, R, kTemperature, "", {"battery_drift"}, {"hot", "late"}, "falls over minutes", {kWarm, kLogVoltage},
       [](SimParams& p, int j, Theta x) { joint(p, j).friction_temperature += x[0]; }},
      {"dwell_stiction", "F12", "stiction that grows with the time at rest", "(static + coulomb) dwell_rate ln(1 + rest/1 s) at breakaway", F, P, S,
       {{"static", "N m", 0, 0, 0.6, 0.05, Unit::torque}, {"dwell_rate", "-", 0, 0, 1, 0.1}},
       false, {{0.05, 0.2}}, 1, R, 0, "", {"stribeck_friction"}, {"breakaway", "standstill"}, "after long rests only", {kHolds},
       [](SimParams& p, int j, Theta x) {
         joint(p, j).static_friction += x[0];
         joint(p, j).dwell_rate += x[1];
       }},
  };
}

}  // namespace sanso::diagnose
