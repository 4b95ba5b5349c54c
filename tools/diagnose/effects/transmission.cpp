// Transmission: T1 to T7 of the method page.
#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {

std::vector<Effect> transmission_effects() {
  constexpr Family F = Family::transmission;
  constexpr Port P = Port::transmission;
  constexpr Scope S = Scope::joint;
  return {
      {"backlash", "T1", "backlash", "motor and link are two masses with play of width `width`", F, P, S,
       {{"width", "rad", 0, 0, 0.06, 0.01, Unit::angle}, {"encoder_at_motor", "0 or 1", 0, 0, 1, 1, Unit::none, true}},
       false, {{0.005, 0}, {0.02, 0}, {0.005, 1}, {0.02, 1}}, 1, kR2 | kR3, 0, "D",
       {"coulomb_friction", "presliding_friction", "servo_deadband", "joint_compliance", "command_delay"},
       {"reversal"}, "lost motion at reversal; the load hangs free for a moment", {kAddPayload, kHalveGain, kAmplitudeSweep},
       [](SimParams& p, int j, Theta x) {
         if (x[0] == 0.0) return;
         joint(p, j).backlash += x[0];
         joint(p, j).encoder_at_motor = x[1] >= 0.5;
       }},
      {"joint_compliance", "T2", "joint compliance", "spring 1/compliance and damper between motor and link", F, P, S,
       {{"compliance", "rad/(N m)", 0, 0, 0.1, 0.01, Unit::compliance},
        {"damping", "N m s/rad", 0, 0, 1, 0.05, Unit::viscous},
        {"encoder_at_motor", "0 or 1", 0, 0, 1, 1, Unit::none, true}},
       false, {{0.005, 0.05, 0}, {0.03, 0.05, 0}, {0.005, 0.05, 1}, {0.03, 0.05, 1}}, 1, kR2 | kR3 | kR6, 0, "BG",
       {"servo_p_gain", "command_delay", "sensor_delay", "servo_d_gain", "servo_profile", "backlash", "contact_compliance"},
       {"accelerating", "high load"}, "resonance, sag with load", {kOutsideSensor, kChirp, kAddPayload},
       [](SimParams& p, int j, Theta x) {
         if (x[0] == 0.0) return;
         joint(p, j).compliance += x[0];
         joint(p, j).compliance_damping += x[1];
         joint(p, j).encoder_at_motor = x[2] >= 0.5;
       }},
      {"gear_kinematic_error", "T3", "gear ripple (kinematic error)", "link = motor + sine sin(order q) + cosine cos(order q)", F, P, S,
       {{"sine", "rad", 0, -0.02, 0.02, 0.002, Unit::angle},
        {"cosine", "rad", 0, -0.02, 0.02, 0.002, Unit::angle},
        {"order", "1/rad", 1, 1, 400, 1, Unit::per_angle, true}},
       true, {{0.004, 0, 1}, {0, 0.004, 1}, {0.004, 0, 4}, {0, 0.004, 4}, {0.004, 0, 16}, {0, 0.004, 16}}, 0, kR2 | kR3 | kR6, 0, "I",
       {"cogging", "position_friction", "encoder_nonlinearity"}, {"low speed"}, "order lines over the angle", {kFullRange, kOutsideSensor},
       [](SimParams& p, int j, Theta x) {
         if (x[0] == 0.0 && x[1] == 0.0) return;
         joint(p, j).gear_error = {x[0], x[1], x[2]};
       }},
      {"cogging", "T4", "cogging torque", "sine sin(order q) + cosine cos(order q)", F, P, S,
       {{"sine", "N m", 0, -0.2, 0.2, 0.03, Unit::torque},
        {"cosine", "N m", 0, -0.2, 0.2, 0.03, Unit::torque},
        {"order", "1/rad", 1, 1, 400, 1, Unit::per_angle, true}},
       true, {{0.05, 0, 2}, {0, 0.05, 2}, {0.05, 0, 4}, {0, 0.05, 4}, {0.05, 0, 7}, {0, 0.05, 7}, {0.05, 0, 12}, {0, 0.05, 12},
              {0.05, 0, 24}, {0, 0.05, 24}, {0.05, 0, 42}, {0, 0.05, 42}},
       0, kR2 | kR3, 0, "I", {"position_friction", "gear_kinematic_error", "link_com"}, {"low speed"},
       "order lines over the angle, conservative", {kSlowRamps, kFullRange},
       [](SimParams& p, int j, Theta x) {
         if (x[0] == 0.0 && x[1] == 0.0) return;
         joint(p, j).cogging = {x[0], x[1], x[2]};
       }},
      {"rotor_inertia", "T5", "rotor inertia", "+armature ddq", F, P, S,
       {{"armature", "kg m^2", 0, -0.04, 0.1, 0.01, Unit::inertia}},
       true, {{0.01}}, 0, kR2 | kR3, 0, "F", {"link_inertia", "link_mass"}, {"accelerating"}, "grows with acceleration, in its own joint only",
       {kAddPayload, kChirp},
       [](SimParams& p, int j, Theta x) { joint(p, j).armature += x[0]; }},
      {"gear_efficiency", "T6", "gear efficiency", "torque times efficiency when driving, over efficiency when driven", F, P, S,
       {{"efficiency", "-", 1, 0.4, 1, 0.1}},
       false, {{0.9}, {0.7}}, -1, kR2 | kR3 | kR8, 0, "", {"directional_load_friction", "load_friction", "torque_constant"},
       {"driving", "back-driven"}, "the direction of power decides", {kLiftAndLower},
       [](SimParams& p, int j, Theta x) { joint(p, j).efficiency *= x[0]; }},
      {"cable_spring", "T7", "cable or spring", "-stiffness q + torque", F, P, S,
       {{"stiffness", "N m/rad", 0, 0, 2, 0.1, Unit::stiffness}, {"torque", "N m", 0, -1, 1, 0.05, Unit::torque}},
       true, {{0.1, 0}, {0, 0.05}}, 0, kR2 | kR3, 0, "E", {"link_com", "encoder_offset", "ground_slope", "imu_misalignment", "joint_stop"},
       {"standstill", "low speed"}, "conservative, a function of the angle", {kTilt, kPostures},
       [](SimParams& p, int j, Theta x) {
         joint(p, j).spring += x[0];
         joint(p, j).spring_torque += x[1];
       }},
  };
}

}  // namespace sanso::diagnose
