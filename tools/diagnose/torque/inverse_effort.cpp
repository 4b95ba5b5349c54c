// Links by inverse dynamics, joints by their laws.
#include "tools/diagnose/torque/inverse_effort.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/sim/actuator.h"

namespace sanso::diagnose {
namespace {

RobotTree with_payloads(const SimParams& params) {
  RobotTree tree = params.tree;
  for (const LatePayload& p : params.late_payloads)
    add_body(tree.joints[static_cast<std::size_t>(p.joint)].body, p.body);
  return tree;
}

/// Torque of dry friction at this speed, before the sign of motion.
double dry_friction(const JointParams& joint, double q, double speed, double load,
                    double external) {
  double budget = joint.nominal.coulomb + joint.coulomb;
  if (joint.stribeck != 0.0)
    budget +=
        joint.stribeck * std::exp(-std::pow(speed / joint.stribeck_speed, joint.stribeck_shape));
  const double squeezed = std::abs(load - external);
  budget += joint.load_friction * squeezed + joint.quadratic_load_friction * squeezed * squeezed;
  budget += std::abs(joint.drive_friction * load - joint.backdrive_friction * external);
  if (!joint.friction_ripple.zero()) budget += ripple_at(joint.friction_ripple, q);
  return budget;
}

}  // namespace

double joint_effort(const JointParams& joint, double q, double dq, double ddq, double load,
                    double external) {
  const double sign = dq > 0.0 ? 1.0 : (dq < 0.0 ? -1.0 : 0.0);
  double effort = (joint.nominal.armature + joint.armature) * ddq;
  effort += (joint.nominal.viscous + joint.viscous) * dq + joint.viscous_difference * std::abs(dq);
  effort += sign * dry_friction(joint, q, std::abs(dq), load, external);
  effort += joint.coulomb_difference * std::abs(sign);
  effort += joint.air_drag * std::abs(dq) * dq;
  effort += joint.spring * q - joint.spring_torque;
  if (!joint.cogging.zero()) effort -= ripple_at(joint.cogging, q);
  return effort;
}

InverseEffort::InverseEffort(const SimParams& params)
    : joints_(params.joints), dynamics_(with_payloads(params), params.gravity) {
  for (const WorldForce& f : params.forces) {
    if (!std::isfinite(f.from_s) && !std::isfinite(f.until_s))
      dynamics_.add_world_force(f.joint, f.force);
  }
}

void InverseEffort::loads(const MotionSample& motion, JointVector& load) {
  dynamics_.set_positions(motion.q.data());
  dynamics_.inverse_dynamics(motion.dq.data(), motion.ddq.data(), load);
}

std::vector<NeededEffort> InverseEffort::at(const MotionSample& motion) {
  JointVector load{}, bias{};
  loads(motion, load);
  dynamics_.bias(motion.dq.data(), bias);
  std::vector<NeededEffort> out(joints_.size());
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    out[j].load = load[j];
    out[j].external = -bias[j];
    out[j].joint = joint_effort(joints_[j], motion.q[j], motion.dq[j], motion.ddq[j], load[j],
                                out[j].external);
  }
  return out;
}

}  // namespace sanso::diagnose
