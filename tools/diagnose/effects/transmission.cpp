// Transmission: T1 to T7 of the method page.
#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {
namespace {

Effect gear(Effect effect) {
  return of_chapter({Family::transmission, Port::transmission, Scope::joint, kR2 | kR3},
                    std::move(effect));
}

Effect backlash() {
  return gear({
      .id = "backlash",
      .code = "T1",
      .name = "backlash",
      .form = "motor and link are two masses with play of width `width`",
      .parameters = {{"width", "rad", 0, 0, 0.06, 0.01, Unit::angle},
                     {"encoder_at_motor", "0 or 1", 0, 0, 1, 1, Unit::none, true}},
      .smooth = false,
      .probes = {{0.005, 0}, {0.02, 0}, {0.005, 1}, {0.02, 1}},
      .sign = 1,
      .cluster = "D",
      .confounders = {"coulomb_friction", "presliding_friction", "servo_deadband",
                      "joint_compliance", "command_delay"},
      .regimes = {"reversal"},
      .signature = "lost motion at reversal; the load hangs free for a moment",
      .experiments = {kAddPayload, kHalveGain, kAmplitudeSweep},
      .apply =
          [](SimParams& p, int j, Theta x) {
            if (x[0] == 0.0) return;
            joint(p, j).backlash += x[0];
            joint(p, j).encoder_at_motor = x[1] >= 0.5;
          },
  });
}

Effect joint_compliance() {
  return gear({
      .id = "joint_compliance",
      .code = "T2",
      .name = "joint compliance",
      .form = "spring 1/compliance and damper between motor and link",
      .parameters = {{"compliance", "rad/(N m)", 0, 0, 0.1, 0.01, Unit::compliance},
                     {"damping", "N m s/rad", 0, 0, 1, 0.05, Unit::viscous},
                     {"encoder_at_motor", "0 or 1", 0, 0, 1, 1, Unit::none, true}},
      .smooth = false,
      .probes = {{0.005, 0.05, 0}, {0.03, 0.05, 0}, {0.005, 0.05, 1}, {0.03, 0.05, 1}},
      .sign = 1,
      .residuals = kR2 | kR3 | kR6,
      .cluster = "BG",
      .confounders = {"servo_p_gain", "command_delay", "sensor_delay", "servo_d_gain",
                      "servo_profile", "backlash", "contact_compliance"},
      .regimes = {"accelerating", "high load"},
      .signature = "resonance, sag with load",
      .experiments = {kOutsideSensor, kChirp, kAddPayload},
      .apply =
          [](SimParams& p, int j, Theta x) {
            if (x[0] == 0.0) return;
            joint(p, j).compliance += x[0];
            joint(p, j).compliance_damping += x[1];
            joint(p, j).encoder_at_motor = x[2] >= 0.5;
          },
  });
}

Effect gear_kinematic_error() {
  return gear({
      .id = "gear_kinematic_error",
      .code = "T3",
      .name = "gear ripple (kinematic error)",
      .form = "link = motor + sine sin(order q) + cosine cos(order q)",
      .parameters = {{"sine", "rad", 0, -0.06, 0.06, 0.002, Unit::angle},
                     {"cosine", "rad", 0, -0.06, 0.06, 0.002, Unit::angle},
                     {"order", "1/rad", 1, 1, 400, 1, Unit::per_angle, true, Role::order}},
      .probes = both_phases(0.004, {1, 4, 16}),
      .residuals = kR2 | kR3 | kR6,
      .cluster = "I",
      .confounders = {"cogging", "position_friction", "encoder_nonlinearity"},
      .regimes = {"low speed"},
      .signature = "order lines over the angle",
      .experiments = {kFullRange, kOutsideSensor},
      .law = {&ToleranceSettings::zero, {0, 1}, {}, where_it_turns},
      .apply = ripples(&JointParams::gear_error),
  });
}

Effect cogging() {
  return gear({
      .id = "cogging",
      .code = "T4",
      .name = "cogging torque",
      .form = "sine sin(order q) + cosine cos(order q)",
      .parameters = {{"sine", "N m", 0, -0.2, 0.2, 0.03, Unit::torque},
                     {"cosine", "N m", 0, -0.2, 0.2, 0.03, Unit::torque},
                     // once in a turn is a weight
                     {"order", "1/rad", 2, 2, 400, 1, Unit::per_angle, true, Role::order}},
      .terms = kOfAngle,
      .probes = both_phases(0.05, {2, 4, 7, 12, 24, 42}),
      .cluster = "I",
      .confounders = {"position_friction", "gear_kinematic_error", "link_com"},
      .regimes = {"low speed"},
      .signature = "order lines over the angle, conservative",
      .experiments = {kSlowRamps, kFullRange},
      .effort = {.kind = EffortKind::ripple, .order = 1, .values = {0, 1}},
      .apply = ripples(&JointParams::cogging),
  });
}

Effect rotor_inertia() {
  return gear({
      .id = "rotor_inertia",
      .code = "T5",
      .name = "rotor inertia",
      .form = "+armature ddq",
      .parameters = {{"armature", "kg m^2", 0, -0.04, 0.1, 0.01, Unit::inertia}},
      .terms = kOfAcceleration,
      .probes = {{0.01}},
      .needs = kCommand,
      .cluster = "F",
      .confounders = {"link_inertia", "link_mass"},
      .regimes = {"accelerating"},
      .signature = "grows with acceleration, in its own joint only",
      .experiments = {kAddPayload, kChirp},
      .settings = {added_to(&JointSettings::armature)},
      .identified = {Identified::always},
      .tolerances = {{.name = "rotor inertia",
                      .order = 9,
                      .deviation = &ToleranceSettings::armature,
                      .direction = as_stated(&JointSettings::armature)}},
      .effort = {.kind = EffortKind::joint,
                 .order = 3,
                 .stated = &JointSettings::armature,
                 .tolerance = within(6, &ToleranceSettings::armature, &JointSettings::armature)},
      .apply = adds(&JointParams::armature),
  });
}

Effect gear_efficiency() {
  return gear({
      .id = "gear_efficiency",
      .code = "T6",
      .name = "gear efficiency",
      .form = "torque times efficiency when driving, over efficiency when driven",
      .parameters = {{"efficiency", "-", 1, 0.4, 1, 0.1}},
      .smooth = false,
      .probes = {{0.9}, {0.7}},
      .sign = -1,
      .residuals = kR2 | kR3 | kR8,
      .needs = kCommand,
      .confounders = {"directional_load_friction", "load_friction", "torque_constant"},
      .regimes = {"driving", "back-driven"},
      .signature = "the direction of power decides",
      .experiments = {kLiftAndLower},
      .apply = multiplies(&JointParams::efficiency),
  });
}

Effect cable_spring() {
  return gear({
      .id = "cable_spring",
      .code = "T7",
      .name = "cable or spring",
      .form = "-stiffness q + torque",
      .parameters = {{"stiffness", "N m/rad", 0, 0, 2, 0.1, Unit::stiffness},
                     {"torque", "N m", 0, -1, 1, 0.05, Unit::torque}},
      .terms = kOfAngle,
      .probes = {{0.1, 0}, {0, 0.05}},
      .cluster = "E",
      .confounders = {"link_com", "encoder_offset", "ground_slope", "imu_misalignment",
                      "joint_stop"},
      .regimes = {"standstill", "low speed"},
      .signature = "conservative, a function of the angle",
      .experiments = {kTilt, kPostures},
      .effort = {.kind = EffortKind::joint, .order = 9, .values = {0, 1}, .constant = 1},
      .apply = adds(&JointParams::spring, &JointParams::spring_torque),
  });
}

}  // namespace

std::vector<Effect> transmission_effects() {
  return {backlash(),      joint_compliance(), gear_kinematic_error(), cogging(),
          rotor_inertia(), gear_efficiency(),  cable_spring()};
}

}  // namespace sanso::diagnose
