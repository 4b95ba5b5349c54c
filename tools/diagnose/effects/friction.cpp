// Friction: F1 to F12 of the method page.
#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {

std::vector<Effect> friction_effects() {
  constexpr Family F = Family::friction;
  constexpr Port P = Port::transmission;
  constexpr Scope S = Scope::joint;
  constexpr unsigned R = kR2 | kR3 | kR8;
  return {
      {
          .id = "viscous_friction",
          .code = "F1",
          .name = "viscous friction",
          .form = "-viscous dq",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"viscous", "N m s/rad", 0, -1, 2, 0.1, Unit::viscous}},
          .probes = {{0.1}},
          .residuals = R,
          .cluster = "C",
          .confounders = {"servo_d_gain", "torque_constant", "air_drag"},
          .regimes = {"high speed", "low speed"},
          .signature = "grows with speed, dissipative",
          .experiments = {kTorqueOff, kRaiseSupply},
          .apply = [](SimParams& p, int j, Theta x) { joint(p, j).viscous += x[0]; },
      },
      {
          .id = "coulomb_friction",
          .code = "F2",
          .name = "Coulomb friction",
          .form = "-coulomb sign(dq)",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"coulomb", "N m", 0, 0, 0.6, 0.05, Unit::torque}},
          .smooth = false,
          .probes = {{0.03}, {0.1}},
          .sign = 1,
          .residuals = R,
          .cluster = "D",
          .confounders = {"backlash", "presliding_friction", "servo_deadband", "stribeck_friction",
                          "load_friction"},
          .regimes = {"reversal", "low speed", "standstill"},
          .signature = "step at reversal, the same at all speeds",
          .experiments = {kHalveGain, kAddPayload, kAmplitudeSweep},
          .apply = [](SimParams& p, int j, Theta x) { joint(p, j).coulomb += x[0]; },
      },
      {
          .id = "stribeck_friction",
          .code = "F3",
          .name = "Stribeck friction and stiction",
          .form = "-stribeck exp(-|dq/speed|^shape) sign(dq)",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"stribeck", "N m", 0, 0, 0.6, 0.05, Unit::torque},
                         {"speed", "rad/s", 0.2, 0.02, 3, 0.1, Unit::speed},
                         {"shape", "-", 1, 0.5, 4, 0.5}},
          .smooth = false,
          .probes = {{0.1, 0.1, 1}, {0.1, 0.4, 1}, {0.1, 1.2, 1}},
          .sign = 1,
          .residuals = R,
          .cluster = "D",
          .confounders = {"coulomb_friction", "dwell_stiction"},
          .contains = {"coulomb_friction"},
          .regimes = {"breakaway", "low speed", "reversal"},
          .signature = "sticks, then slips: shows in slow motion and at breakaway",
          .experiments = {kSlowRamps},
          .apply =
              [](SimParams& p, int j, Theta x) {
                if (x[0] == 0.0) return;
                joint(p, j).stribeck += x[0];
                joint(p, j).stribeck_speed = x[1];
                joint(p, j).stribeck_shape = x[2];
              },
      },
      {
          .id = "load_friction",
          .code = "F4",
          .name = "load-dependent friction",
          .form = "-load |tau_motor - tau_external| sign(dq)",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"load", "-", 0, 0, 0.5, 0.05}},
          .smooth = false,
          .probes = {{0.05}, {0.2}},
          .sign = 1,
          .residuals = R,
          .cluster = "D",
          .confounders = {"coulomb_friction", "directional_load_friction",
                          "quadratic_load_friction", "gear_efficiency"},
          .regimes = {"high load", "driving"},
          .signature = "grows with the load the gear carries",
          .experiments = {kAddPayload, kLiftAndLower},
          .apply = [](SimParams& p, int j, Theta x) { joint(p, j).load_friction += x[0]; },
      },
      {
          .id = "directional_load_friction",
          .code = "F5",
          .name = "load friction that differs with the direction of power",
          .form = "-|drive tau_motor - backdrive tau_external| sign(dq)",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"drive", "-", 0, 0, 0.6, 0.05}, {"backdrive", "-", 0, 0, 0.6, 0.05}},
          .smooth = false,
          .probes = {{0.1, 0}, {0, 0.1}},
          .sign = 1,
          .residuals = R,
          .confounders = {"load_friction", "gear_efficiency", "torque_constant"},
          .contains = {"load_friction"},
          .regimes = {"driving", "back-driven"},
          .signature = "driving and being driven differ",
          .experiments = {kLiftAndLower, kAddPayload},
          .apply =
              [](SimParams& p, int j, Theta x) {
                joint(p, j).drive_friction += x[0];
                joint(p, j).backdrive_friction += x[1];
              },
      },
      {
          .id = "quadratic_load_friction",
          .code = "F6",
          .name = "friction with the square of the load",
          .form = "-quadratic (tau_motor - tau_external)^2 sign(dq)",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"quadratic", "1/(N m)", 0, 0, 0.2, 0.02, Unit::per_torque}},
          .smooth = false,
          .probes = {{0.05}},
          .sign = 1,
          .residuals = R,
          .confounders = {"load_friction"},
          .regimes = {"high load"},
          .signature = "only under heavy load",
          .experiments = {kAddPayload},
          .apply = [](SimParams& p, int j,
                      Theta x) { joint(p, j).quadratic_load_friction += x[0]; },
      },
      {
          .id = "asymmetric_friction",
          .code = "F7",
          .name = "friction that differs forwards and backwards",
          .form = "-(coulomb_difference + viscous_difference |dq|) while moving, in one direction "
                  "more, in the other less",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"coulomb_difference", "N m", 0, -0.3, 0.3, 0.03, Unit::torque},
                         {"viscous_difference", "N m s/rad", 0, -0.5, 0.5, 0.05, Unit::viscous}},
          .smooth = false,
          .probes = {{0.05, 0}, {-0.05, 0}, {0, 0.1}, {0, -0.1}},
          .residuals = R,
          .confounders = {"encoder_offset", "link_com", "cable_spring"},
          .regimes = {"high speed", "low speed"},
          .signature = "the sign of motion decides",
          .experiments = {kTilt},
          .apply =
              [](SimParams& p, int j, Theta x) {
                joint(p, j).coulomb_difference += x[0];
                joint(p, j).viscous_difference += x[1];
              },
      },
      {
          .id = "presliding_friction",
          .code = "F8",
          .name = "presliding friction (LuGre)",
          .form = "dz = dq - |dq| z/(compliance budget), torque z/compliance + damping dz",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"coulomb", "N m", 0, 0, 0.6, 0.05, Unit::torque},
                         {"compliance", "rad/(N m)", 0, 0, 0.2, 0.01, Unit::compliance},
                         {"damping", "N m s/rad", 0, 0, 1, 0.02, Unit::viscous}},
          .smooth = false,
          .probes = {{0.05, 0.02, 0.02}, {0.05, 0.1, 0.02}},
          .sign = 1,
          .residuals = R,
          .cluster = "D",
          .confounders = {"coulomb_friction", "joint_compliance", "backlash",
                          "maxwell_slip_friction"},
          .contains = {"coulomb_friction"},
          .regimes = {"reversal", "standstill"},
          .signature = "a spring below half a degree, hysteresis that does not depend on speed",
          .experiments = {kAmplitudeSweep, kSlowRamps},
          .apply =
              [](SimParams& p, int j, Theta x) {
                joint(p, j).coulomb += x[0];
                joint(p, j).presliding_compliance += x[1];
                joint(p, j).presliding_damping += x[2];
              },
      },
      {
          .id = "maxwell_slip_friction",
          .code = "F9",
          .name = "generalised Maxwell slip (4 elements)",
          .form = "sum of 4 springs that slide at torque shares i^spread",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"torque", "N m", 0, 0, 0.6, 0.05, Unit::torque},
                         {"stiffness", "N m/rad", 50, 5, 5000, 20, Unit::stiffness},
                         {"spread", "-", 1, 0, 3, 0.5}},
          .smooth = false,
          .probes = {{0.1, 20, 1}, {0.1, 100, 1}},
          .sign = 1,
          .residuals = R,
          .cluster = "D",
          .confounders = {"presliding_friction", "coulomb_friction"},
          .contains = {"coulomb_friction"},
          .regimes = {"reversal", "standstill"},
          .signature = "hysteresis with non-local memory",
          .experiments = {kAmplitudeSweep},
          .apply =
              [](SimParams& p, int j, Theta x) {
                if (x[0] == 0.0) return;
                joint(p, j).slip_torque += x[0];
                joint(p, j).slip_stiffness = x[1];
                joint(p, j).slip_spread = x[2];
              },
      },
      {
          .id = "position_friction",
          .code = "F10",
          .name = "friction that depends on the angle",
          .form = "-(sine sin(order q) + cosine cos(order q)) sign(dq)",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"sine", "N m", 0, -0.4, 0.4, 0.05, Unit::torque},
                         {"cosine", "N m", 0, -0.4, 0.4, 0.05, Unit::torque},
                         {"order", "1/rad", 1, 1, 12, 1, Unit::per_angle, true, Role::order}},
          .smooth = false,
          .probes = {{0.05, 0, 1},
                     {0, 0.05, 1},
                     {0.05, 0, 2},
                     {0, 0.05, 2},
                     {0.05, 0, 4},
                     {0, 0.05, 4},
                     {0.05, 0, 8},
                     {0, 0.05, 8}},
          .residuals = R,
          .cluster = "I",
          .confounders = {"cogging", "gear_kinematic_error"},
          .regimes = {"low speed"},
          .signature = "periodic over the angle, dissipative",
          .experiments = {kSlowRamps, kFullRange},
          .apply =
              [](SimParams& p, int j, Theta x) {
                if (x[0] == 0.0 && x[1] == 0.0) return;
                joint(p, j).friction_ripple = {x[0], x[1], x[2]};
              },
      },
      {
          .id = "thermal_friction",
          .code = "F11",
          .name = "friction that falls with temperature",
          .form = "all friction times exp(-rate (T - T0))",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"rate", "1/K", 0, 0, 0.05, 0.005}},
          .smooth = false,
          .probes = {{0.01}, {0.03}},
          .sign = 1,
          .residuals = R,
          .needs = kTemperature,
          .confounders = {"battery_drift"},
          .regimes = {"hot", "late"},
          .signature = "falls over minutes",
          .experiments = {kWarm, kLogVoltage},
          .apply = [](SimParams& p, int j, Theta x) { joint(p, j).friction_temperature += x[0]; },
      },
      {
          .id = "dwell_stiction",
          .code = "F12",
          .name = "stiction that grows with the time at rest",
          .form = "(static + (static + coulomb) dwell_rate ln(1 + rest/1 s)) exp(-|dq|/speed)",
          .family = F,
          .port = P,
          .scope = S,
          .parameters = {{"static", "N m", 0, 0, 0.6, 0.05, Unit::torque},
                         {"dwell_rate", "-", 0, 0, 1, 0.1},
                         {"speed", "rad/s", 0.2, 0.005, 1, 0.05, Unit::speed}},
          .smooth = false,
          .probes = {{0.05, 0.2, 0.2}, {0.05, 0.5, 0.02}},
          .sign = 1,
          .residuals = R,
          .confounders = {"stribeck_friction"},
          .contains = {"stribeck_friction"},
          .regimes = {"breakaway", "standstill"},
          .signature = "after long rests only",
          .experiments = {kHolds},
          .apply =
              [](SimParams& p, int j, Theta x) {
                joint(p, j).static_friction += x[0];
                joint(p, j).dwell_rate += x[1];
                if (x[0] != 0.0 || x[1] != 0.0) joint(p, j).static_speed = x[2];
              },
      },
  };
}

}  // namespace sanso::diagnose
