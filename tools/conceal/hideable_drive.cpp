// Friction and gears: how to hide them at a joint with a strength, and what the answer will say.
#include <algorithm>
#include <cmath>

#include "tools/conceal/hideable_families.h"

namespace sanso::conceal {

// What depends on speed and load alone.
std::vector<Hideable> friction_of_speed_and_load() {
  return {
      on_joint("viscous_friction", 0.2, 2.0,
               [](JointTruth& j, double s, Random&) {
                 j.viscous += s;
                 return Parameters{{"viscous", s}};
               },
               {"servo_d_gain", "torque_constant"}),
      on_joint("coulomb_friction", 0.08, 0.5,
               [](JointTruth& j, double s, Random&) {
                 j.coulomb += s;
                 return Parameters{{"coulomb", s}};
               }),
      on_joint("stribeck_friction", 0.1, 0.6,
               [](JointTruth& j, double s, Random& r) {
                 j.stribeck = s;
                 j.stribeck_speed = r.uniform(0.1, 0.5);
                 return Parameters{{"stribeck", s}, {"speed", j.stribeck_speed}};
               }),
      on_joint("load_friction", 0.08, 0.4,
               [](JointTruth& j, double s, Random&) {
                 j.load = s;
                 return Parameters{{"load", s}};
               }),
      on_joint("directional_load_friction", 0.15, 0.5,
               [](JointTruth& j, double s, Random& r) {
                 j.drive = s;
                 j.backdrive = s * r.uniform(0.1, 0.5);
                 return Parameters{{"drive", j.drive}, {"backdrive", j.backdrive}};
               }),
      on_joint("quadratic_load_friction", 0.08, 0.2,
               [](JointTruth& j, double s, Random&) {
                 j.quadratic = s;
                 return Parameters{{"quadratic", s}};
               }),
  };
}

// What depends on direction, angle or what was before.
std::vector<Hideable> friction_of_side_and_memory() {
  return {
      on_joint("asymmetric_friction", 0.06, 0.3,
               [](JointTruth& j, double s, Random& r) {
                 s *= sign(r);
                 // friction stays positive both ways
                 j.coulomb += std::max(0.0, std::abs(s) - j.coulomb);
                 j.coulomb_difference = s;
                 return Parameters{{"coulomb_difference", s}};
               }),
      on_joint("presliding_friction", 0.1, 0.5,
               [](JointTruth& j, double s, Random& r) {
                 const double compliance = r.uniform(0.03, 0.15);  // rad/(N m)
                 j.coulomb += s;
                 j.bristle_stiffness = 1 / compliance;
                 j.bristle_damping = 0.1;
                 return Parameters{{"coulomb", s}, {"compliance", compliance}};
               }),
      on_joint("position_friction", 0.06, 0.4,
               [](JointTruth& j, double s, Random& r) {
                 const double phase = r.uniform(0, 2 * plant::kPi);
                 j.ripple_order = 1 + static_cast<double>(r.bits() % 8);
                 j.ripple_sine = s * std::sin(phase);
                 j.ripple_cosine = s * std::cos(phase);
                 j.coulomb += std::max(0.0, s - j.coulomb);
                 return Parameters{{"sine", j.ripple_sine},
                                   {"cosine", j.ripple_cosine},
                                   {"order", j.ripple_order}};
               }),
      on_joint("dwell_stiction", 0.1, 0.5,
               [](JointTruth& j, double s, Random& r) {
                 j.static_friction = s;
                 j.dwell_rate = r.uniform(0.3, 1.0);
                 return Parameters{{"static", s}, {"dwell_rate", j.dwell_rate}};
               }),
  };
}

// Between motor and link.
std::vector<Hideable> gear_effects() {
  return {
      on_joint("backlash", 0.02, 0.06,
               [](JointTruth& j, double s, Random&) {
                 j.backlash = s;
                 return Parameters{{"width", s}};
               }),
      on_joint("joint_compliance", 0.02, 0.1,
               [](JointTruth& j, double s, Random& r) {
                 j.compliance = s;
                 j.compliance_damping = r.uniform(0.05, 0.4);
                 return Parameters{{"compliance", s}, {"damping", j.compliance_damping}};
               }),
      on_joint("cogging", 0.05, 0.2,
               [](JointTruth& j, double s, Random& r) {
                 const double phase = r.uniform(0, 2 * plant::kPi);
                 j.cogging_order = 4 + static_cast<double>(r.bits() % 20);
                 j.cogging_sine = s * std::sin(phase);
                 j.cogging_cosine = s * std::cos(phase);
                 return Parameters{{"sine", j.cogging_sine},
                                   {"cosine", j.cogging_cosine},
                                   {"order", j.cogging_order}};
               }),
      on_joint("rotor_inertia", 0.02, 0.1,
               [](JointTruth& j, double s, Random&) {
                 j.armature += s;
                 return Parameters{{"armature", s}};
               }),
      on_joint("gear_efficiency", 0.15, 0.6,
               [](JointTruth& j, double s, Random&) {
                 j.efficiency = 1 - s;
                 return Parameters{{"efficiency", j.efficiency}};
               }),
  };
}

// What pulls at the joint from outside.
std::vector<Hideable> effects_at_the_joint() {
  return {
      on_joint("cable_spring", 0.3, 2.0,
               [](JointTruth& j, double s, Random& r) {
                 j.spring = s;
                 j.spring_torque = s * r.uniform(-0.3, 0.3);
                 return Parameters{{"stiffness", s}, {"torque", j.spring_torque}};
               }),
      on_joint("joint_stop", 10, 500,
               [](JointTruth& j, double s, Random& r) {
                 j.stop_stiffness = s;
                 j.stop_side = sign(r);
                 j.stop_position = j.stop_side * r.uniform(0.2, 0.3);
                 return Parameters{
                     {"stiffness", s}, {"position", j.stop_position}, {"side", j.stop_side}};
               }),
      on_joint("air_drag", 0.04, 0.2,
               [](JointTruth& j, double s, Random&) {
                 j.air_drag = s;
                 return Parameters{{"drag", s}};
               }),
  };
}

}  // namespace sanso::conceal
