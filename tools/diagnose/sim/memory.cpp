// Figures that have no part in what is remembered are set to those of a plain joint, and the rest
// is compared. What enters which memory (follow_run.h, transmission_step.h, servo.h):
//
//   bristles          dry friction and how it depends on place; on load: all that is two masses'
//   slip, rest        the motion alone
//   two masses        motor torque, inertia and gravity; not what acts on the link: it moves as
//                     measured
//   integral          command and reading; where it begins, what the posture takes to hold
//   profile, filters  command and reading
#include "tools/diagnose/sim/memory.h"

#include <algorithm>

#include "tools/diagnose/sim/transmission.h"

namespace sanso::diagnose {
namespace {

bool two_masses(const JointParams& j) { return j.backlash > 0.0 || j.compliance > 0.0; }

bool bristles_feel_load(const JointParams& j) {
  return j.presliding_compliance > 0.0 &&
         (j.load_friction != 0.0 || j.drive_friction != 0.0 || j.backdrive_friction != 0.0 ||
          j.quadratic_load_friction != 0.0 || j.efficiency != 1.0);
}

/// The motor's torque enters.
bool torque_counts(const JointParams& j) { return two_masses(j) || bristles_feel_load(j); }

bool integrates(const JointParams& j) { return j.integral_rate > 0.0 || j.nominal.i_gain > 0.0; }

bool heats(const JointParams& j) { return j.derating != 0.0 || j.friction_temperature != 0.0; }

/// The joint without what acts on its link, which moves as measured.
void forget_link(JointParams& j) {
  const JointParams plain;
  j.spring = plain.spring, j.spring_torque = plain.spring_torque;
  j.cogging = plain.cogging;
  j.air_drag = plain.air_drag;
  j.stop_stiffness = plain.stop_stiffness, j.stop_position = plain.stop_position;
  j.stop_side = plain.stop_side, j.stop_loss = plain.stop_loss;
}

/// Without what only torques and masses depend on.
void forget_torque(JointParams& j) {
  const JointParams plain;
  j.viscous = plain.viscous, j.viscous_difference = plain.viscous_difference;
  j.coulomb_difference = plain.coulomb_difference;
  j.creep_speed = plain.creep_speed;
  j.armature = plain.armature;
  j.no_load_speed = plain.no_load_speed;
  j.current_limit = plain.current_limit;
  if (integrates(j)) return;  // begins with what holds the posture
  j.torque_scale = plain.torque_scale;
  j.resistance_scale = plain.resistance_scale;
}

/// Without dry friction, where no bristle bends to it.
void forget_friction(JointParams& j) {
  const JointParams plain;
  j.coulomb = plain.coulomb;
  j.stribeck = plain.stribeck, j.stribeck_speed = plain.stribeck_speed;
  j.stribeck_shape = plain.stribeck_shape;
  j.load_friction = plain.load_friction;
  j.drive_friction = plain.drive_friction, j.backdrive_friction = plain.backdrive_friction;
  j.quadratic_load_friction = plain.quadratic_load_friction;
  j.friction_ripple = plain.friction_ripple;
  j.static_friction = plain.static_friction, j.static_speed = plain.static_speed;
  j.efficiency = plain.efficiency;
}

JointParams remembered_part(JointParams j) {
  forget_link(j);
  if (torque_counts(j)) return j;
  forget_torque(j);
  if (j.presliding_compliance == 0.0) forget_friction(j);
  return j;
}

template <class Predicate>
bool any_joint(const SimParams& p, const Predicate& predicate) {
  return std::any_of(p.joints.begin(), p.joints.end(), predicate);
}

/// What links weigh and what supplies them.
bool masses_count(const SimParams& p) {
  return any_joint(p, [](const JointParams& j) { return torque_counts(j) || integrates(j); });
}

}  // namespace

bool remember_alike(const SimParams& a, const SimParams& b) {
  // currents, and what depends on them, are not told apart here
  if (a.supply_resistance != 0.0 || b.supply_resistance != 0.0) return false;
  if (any_joint(a, heats) || any_joint(b, heats)) return false;
  const bool joints = std::equal(a.joints.begin(), a.joints.end(), b.joints.begin(), b.joints.end(),
                                 [](const JointParams& one, const JointParams& other) {
                                   return remembered_part(one) == remembered_part(other);
                                 });
  if (!joints || a.settings != b.settings || a.supply_slope != b.supply_slope) return false;
  if (!masses_count(a) && !masses_count(b)) return true;
  return a.supply_level == b.supply_level && a.tree == b.tree && a.gravity == b.gravity &&
         a.forces == b.forces && a.late_payloads == b.late_payloads;
}

}  // namespace sanso::diagnose
