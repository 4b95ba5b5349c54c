// Friction: F1 to F12 of the method page.
#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {
namespace {

Effect friction(Effect effect) {
  return of_chapter({Family::friction, Port::transmission, Scope::joint, kR2 | kR3 | kR8},
                    std::move(effect));
}

/// Damping that the actuator itself gives: back-EMF of a servo, derivative gain of a position loop,
/// known friction.
std::vector<double> actuator_damping(const SimParams& p, std::size_t j) {
  const JointSettings& s = p.joints[j].nominal;
  double damping = s.viscous + s.kd;
  if (s.actuator == Actuator::dc_servo) damping += s.torque_constant * s.back_emf / s.resistance;
  return damping > 0.0 ? std::vector<double>{damping} : std::vector<double>{};
}

/// Dry friction that the model states, N m.
double stated_friction(const SimParams& p, std::size_t j) { return p.joints[j].nominal.coulomb; }
/// A newton metre as a share of that.
double of_stated_friction(const SimParams& p, std::size_t j) {
  const double stated = stated_friction(p, j);
  return stated > 0.0 ? 1.0 / stated : 0.0;
}

double where_it_states_friction(const SimParams& p, std::size_t j) {
  return stated_friction(p, j) > 0.0 ? 1.0 : 0.0;
}

Effect viscous_friction() {
  return friction({
      .id = "viscous_friction",
      .code = "F1",
      .name = "viscous friction",
      .form = "-viscous dq",
      .parameters = {{"viscous", "N m s/rad", 0, -1, 2, 0.1, Unit::viscous}},
      .probes = {{0.1}},
      .cluster = "C",
      .confounders = {"servo_d_gain", "torque_constant", "air_drag"},
      .regimes = {"high speed", "low speed"},
      .signature = "grows with speed, dissipative",
      .experiments = {kTorqueOff, kRaiseSupply},
      .settings = {added_to(&JointSettings::viscous)},
      .identified = {Identified::always},
      .tolerances = {{.name = "damping",
                      .order = 3,
                      .deviation = &ToleranceSettings::damping,
                      .direction = actuator_damping}},
      .effort = {.kind = EffortKind::joint,
                 .order = 2,
                 .stated = &JointSettings::viscous,
                 .beside_gain = true,
                 .tolerance = within(4, &ToleranceSettings::damping, &JointSettings::viscous)},
      .drive = DriveQuestion{JointFigure::speed, true},
      .apply = adds(&JointParams::viscous),
  });
}

Effect coulomb_friction() {
  return friction({
      .id = "coulomb_friction",
      .code = "F2",
      .name = "Coulomb friction",
      .form = "-coulomb sign(dq)",
      .parameters = {{"coulomb", "N m", 0, 0, 0.6, 0.05, Unit::torque}},
      .smooth = false,
      .probes = {{0.03}, {0.1}},
      .sign = 1,
      .cluster = "D",
      .confounders = {"backlash", "presliding_friction", "servo_deadband", "stribeck_friction",
                      "load_friction"},
      .regimes = {"reversal", "low speed", "standstill"},
      .signature = "step at reversal, the same at all speeds",
      .experiments = {kHalveGain, kAddPayload, kAmplitudeSweep},
      .settings = {added_to(&JointSettings::coulomb)},
      .identified = {Identified::always},
      .tolerances = {{.name = "dry friction",
                      .order = 4,
                      .deviation = &ToleranceSettings::friction,
                      .direction = as_stated(&JointSettings::coulomb)}},
      .effort = {.kind = EffortKind::joint,
                 .order = 1,
                 .stated = &JointSettings::coulomb,
                 .dry = DryFriction::adds,
                 .beside_gain = true,
                 .tolerance = within(5, &ToleranceSettings::friction, &JointSettings::coulomb)},
      .drive = DriveQuestion{JointFigure::dry, true},
      .apply = adds(&JointParams::coulomb),
  });
}

Effect stribeck_friction() {
  return friction({
      .id = "stribeck_friction",
      .code = "F3",
      .name = "Stribeck friction and stiction",
      .form = "-stribeck exp(-|dq/speed|^shape) sign(dq)",
      .parameters = {{"stribeck", "N m", 0, 0, 0.6, 0.05, Unit::torque},
                     {"speed", "rad/s", 0.2, 0.02, 3, 0.1, Unit::speed},
                     {"shape", "-", 1, 0.5, 4, 0.5}},
      .smooth = false,
      .probes = {{0.1, 0.1, 1}, {0.1, 0.4, 1}, {0.1, 1.2, 1}},
      .sign = 1,
      .cluster = "D",
      .confounders = {"coulomb_friction", "dwell_stiction"},
      .contains = {"coulomb_friction"},
      .regimes = {"breakaway", "low speed", "reversal"},
      .signature = "sticks, then slips: shows in slow motion and at breakaway",
      .experiments = {kSlowRamps},
      .effort = {.kind = EffortKind::joint,
                 .order = 4,
                 .held = {{0, 0.1, 1}, {0, 0.3, 1}, {0, 1, 1}},
                 .dry = DryFriction::adds},
      .apply =
          [](SimParams& p, int j, Theta x) {
            if (x[0] == 0.0) return;
            joint(p, j).stribeck += x[0];
            joint(p, j).stribeck_speed = x[1];
            joint(p, j).stribeck_shape = x[2];
          },
  });
}

Effect load_friction() {
  return friction({
      .id = "load_friction",
      .code = "F4",
      .name = "load-dependent friction",
      .form = "-load |tau_motor - tau_external| sign(dq)",
      .parameters = {{"load", "-", 0, 0, 0.5, 0.05}},
      .smooth = false,
      .probes = {{0.05}, {0.2}},
      .sign = 1,
      .cluster = "D",
      .confounders = {"coulomb_friction", "directional_load_friction", "quadratic_load_friction",
                      "gear_efficiency"},
      .regimes = {"high load", "driving"},
      .signature = "grows with the load the gear carries",
      .experiments = {kAddPayload, kLiftAndLower},
      .effort = {.kind = EffortKind::joint, .order = 5},
      .drive = DriveQuestion{JointFigure::load, true},
      .apply = adds(&JointParams::load_friction),
  });
}

Effect directional_load_friction() {
  return friction({
      .id = "directional_load_friction",
      .code = "F5",
      .name = "load friction that differs with the direction of power",
      .form = "-|drive tau_motor - backdrive tau_external| sign(dq)",
      .parameters = {{"drive", "-", 0, 0, 0.6, 0.05}, {"backdrive", "-", 0, 0, 0.6, 0.05}},
      .smooth = false,
      .probes = {{0.1, 0}, {0, 0.1}},
      .sign = 1,
      .confounders = {"load_friction", "gear_efficiency", "torque_constant"},
      .contains = {"load_friction"},
      .regimes = {"driving", "back-driven"},
      .signature = "driving and being driven differ",
      .experiments = {kLiftAndLower, kAddPayload},
      .apply = adds(&JointParams::drive_friction, &JointParams::backdrive_friction),
  });
}

Effect quadratic_load_friction() {
  return friction({
      .id = "quadratic_load_friction",
      .code = "F6",
      .name = "friction with the square of the load",
      .form = "-quadratic (tau_motor - tau_external)^2 sign(dq)",
      .parameters = {{"quadratic", "1/(N m)", 0, 0, 0.2, 0.02, Unit::per_torque}},
      .smooth = false,
      .probes = {{0.05}},
      .sign = 1,
      .confounders = {"load_friction"},
      .regimes = {"high load"},
      .signature = "only under heavy load",
      .experiments = {kAddPayload},
      .effort = {.kind = EffortKind::joint, .order = 6},
      .apply = adds(&JointParams::quadratic_load_friction),
  });
}

Effect asymmetric_friction() {
  return friction({
      .id = "asymmetric_friction",
      .code = "F7",
      .name = "friction that differs forwards and backwards",
      .form = "-(coulomb_difference + viscous_difference |dq|) while moving, in one direction "
              "more, in the other less",
      .parameters = {{"coulomb_difference", "N m", 0, -0.3, 0.3, 0.03, Unit::torque},
                     {"viscous_difference", "N m s/rad", 0, -0.5, 0.5, 0.05, Unit::viscous}},
      .smooth = false,
      .probes = {{0.05, 0}, {-0.05, 0}, {0, 0.1}, {0, -0.1}},
      .confounders = {"encoder_offset", "link_com", "cable_spring"},
      .regimes = {"high speed", "low speed"},
      .signature = "the sign of motion decides",
      .experiments = {kTilt},
      .effort = {.kind = EffortKind::joint, .order = 7, .values = {0, 1}},
      .apply = adds(&JointParams::coulomb_difference, &JointParams::viscous_difference),
  });
}

Effect presliding_friction() {
  return friction({
      .id = "presliding_friction",
      .code = "F8",
      .name = "presliding friction (LuGre)",
      .form = "dz = dq - |dq| z/(compliance budget), torque z/compliance + damping dz",
      .parameters = {{"coulomb", "N m", 0, 0, 0.6, 0.05, Unit::torque},
                     {"compliance", "rad/(N m)", 0, 0, 0.2, 0.01, Unit::compliance},
                     {"damping", "N m s/rad", 0, 0, 1, 0.02, Unit::viscous}},
      .smooth = false,
      .terms = kOfSlip,
      .probes = {{0.05, 0.02, 0.02}, {0.05, 0.1, 0.02}},
      .sign = 1,
      .cluster = "D",
      .confounders = {"coulomb_friction", "joint_compliance", "backlash", "maxwell_slip_friction"},
      .contains = {"coulomb_friction"},
      .regimes = {"reversal", "standstill"},
      .signature = "a spring below half a degree, hysteresis that does not depend on speed",
      .experiments = {kAmplitudeSweep, kSlowRamps},
      .law = {&ToleranceSettings::bend, {1}, {}, stated_friction},
      .builds_up = true,
      .apply = adds(&JointParams::coulomb, &JointParams::presliding_compliance,
                    &JointParams::presliding_damping),
  });
}

Effect creeping_friction() {
  return friction({
      .id = "creeping_friction",
      .code = "F13",
      .name = "dry friction that creeps",
      .form = "dry friction times min(|dq / speed|, 1): under load the joint does not stand still",
      .parameters = {{"speed", "rad/s", 0, 0, 0.5, 0.03, Unit::speed}},
      .smooth = false,
      .probes = {{0.03}, {0.1}},
      .sign = 1,
      .cluster = "D",
      .confounders = {"presliding_friction", "viscous_friction", "coulomb_friction"},
      .regimes = {"standstill", "low speed", "breakaway"},
      .signature = "creeps where it should stick",
      .experiments = {kHolds, kSlowRamps},
      // where a nominal model has dry friction its law at rest is anybody's: bristles, lubrication,
      // the regularised sign of a physics engine
      .law = {&ToleranceSettings::creep, {0}, {}, where_it_states_friction},
      .apply = adds(&JointParams::creep_speed),
  });
}

Effect maxwell_slip_friction() {
  return friction({
      .id = "maxwell_slip_friction",
      .code = "F9",
      .name = "generalised Maxwell slip (4 elements)",
      .form = "sum of 4 springs that slide at torque shares i^spread",
      .parameters = {{"torque", "N m", 0, 0, 0.6, 0.05, Unit::torque},
                     {"stiffness", "N m/rad", 50, 5, 5000, 20, Unit::stiffness},
                     {"spread", "-", 1, 0, 3, 0.5}},
      .smooth = false,
      .terms = kOfSlip,
      .probes = {{0.1, 20, 1}, {0.1, 100, 1}},
      .sign = 1,
      .cluster = "D",
      .confounders = {"presliding_friction", "coulomb_friction"},
      .contains = {"coulomb_friction"},
      .regimes = {"reversal", "standstill"},
      .signature = "hysteresis with non-local memory",
      .experiments = {kAmplitudeSweep},
      // dry friction is stated to so much, and nobody states over which angle it builds up
      .law = {&ToleranceSettings::friction, {0}, {1, 2}, of_stated_friction},
      .builds_up = true,
      .apply =
          [](SimParams& p, int j, Theta x) {
            if (x[0] == 0.0) return;
            joint(p, j).slip_torque += x[0];
            joint(p, j).slip_stiffness = x[1];
            joint(p, j).slip_spread = x[2];
          },
  });
}

Effect position_friction() {
  return friction({
      .id = "position_friction",
      .code = "F10",
      .name = "friction that depends on the angle",
      .form = "-(sine sin(order q) + cosine cos(order q)) sign(dq)",
      .parameters = {{"sine", "N m", 0, -0.4, 0.4, 0.05, Unit::torque},
                     {"cosine", "N m", 0, -0.4, 0.4, 0.05, Unit::torque},
                     {"order", "1/rad", 1, 1, 12, 1, Unit::per_angle, true, Role::order}},
      .smooth = false,
      .probes = both_phases(0.05, {1, 2, 4, 8}),
      .cluster = "I",
      .confounders = {"cogging", "gear_kinematic_error"},
      .regimes = {"low speed"},
      .signature = "periodic over the angle, dissipative",
      .experiments = {kSlowRamps, kFullRange},
      // dry friction is stated to so much, and nobody states how it differs over the angle
      .law = {&ToleranceSettings::friction, {0, 1}, {}, of_stated_friction},
      .effort =
          {.kind = EffortKind::ripple, .order = 2, .values = {0, 1}, .dry = DryFriction::ripples},
      .apply = ripples(&JointParams::friction_ripple),
  });
}

Effect thermal_friction() {
  return friction({
      .id = "thermal_friction",
      .code = "F11",
      .name = "friction that falls with temperature",
      .form = "all friction times exp(-rate (T - T0))",
      .parameters = {{"rate", "1/K", 0, 0, 0.05, 0.005}},
      .smooth = false,
      .probes = {{0.01}, {0.03}},
      .sign = 1,
      .needs = kTemperature,
      .confounders = {"battery_drift"},
      .regimes = {"hot", "late"},
      .signature = "falls over minutes",
      .experiments = {kWarm, kLogVoltage},
      .apply = adds(&JointParams::friction_temperature),
  });
}

Effect dwell_stiction() {
  return friction({
      .id = "dwell_stiction",
      .code = "F12",
      .name = "stiction that grows with the time at rest",
      .form = "(static + (static + coulomb) dwell_rate ln(1 + rest/1 s)) exp(-|dq|/speed)",
      .parameters = {{"static", "N m", 0, 0, 0.6, 0.05, Unit::torque},
                     {"dwell_rate", "-", 0, 0, 1, 0.1},
                     {"speed", "rad/s", 0.2, 0.005, 1, 0.05, Unit::speed}},
      .smooth = false,
      .probes = {{0.05, 0.2, 0.2}, {0.05, 0.5, 0.02}},
      .sign = 1,
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
  });
}

}  // namespace

std::vector<Effect> friction_effects() {
  return {viscous_friction(),    coulomb_friction(),          stribeck_friction(),
          load_friction(),       directional_load_friction(), quadratic_load_friction(),
          asymmetric_friction(), presliding_friction(),       maxwell_slip_friction(),
          position_friction(),   thermal_friction(),          dwell_stiction(),
          creeping_friction()};
}

}  // namespace sanso::diagnose
