// The effort that a model needs for a motion: the equations of motion read backwards, with the
// transmission's friction laws of sim/transmission.cpp where they have no memory.
#pragma once

#include <vector>

#include "tools/diagnose/sim/sim_params.h"
#include "tools/diagnose/sim/tree_dynamics.h"

namespace sanso::diagnose {

/// Positions, velocities, accelerations of all joints at one instant, rad (m), rad/s, rad/s^2.
struct MotionSample {
  JointVector q{}, dq{}, ddq{};
};

/// What one joint's motor has to give, N m (N).
struct NeededEffort {
  double load = 0.0;      // M ddq + h of the links alone
  double external = 0.0;  // of `load`, what acts without acceleration, with the sign of a load: -h
  double joint = 0.0;     // rotor, friction, springs, ripple of the joint itself
  /// What the motor gives: links and the joint's own part.
  double total() const { return load + joint; }
};

class InverseEffort {
 public:
  /// Late payloads are taken as attached from the start; forces with a beginning are left out.
  explicit InverseEffort(const SimParams& params);

  /// By joint. Friction at rest (dq = 0) is zero: rows at rest say nothing about it.
  std::vector<NeededEffort> at(const MotionSample& motion);
  /// The links' part alone, by joint.
  void loads(const MotionSample& motion, JointVector& load);

 private:
  std::vector<JointParams> joints_;
  TreeDynamics dynamics_;
};

/// The joint's own part, given its load and external torque.
double joint_effort(const JointParams& joint, double q, double dq, double ddq, double load,
                    double external);

}  // namespace sanso::diagnose
