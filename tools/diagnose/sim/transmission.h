// Transmission port of one joint: friction, play, compliance, springs. Turns the motor torque of
// this step into the joint's part of the implicit equation of motion.
#pragma once

#include "tools/diagnose/sim/actuator.h"
#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

/// What the joint looks like at the middle of the step before its outcome is known.
struct JointInstant {
  double h;         // s
  double q_half;    // rad, q + h/2 dq
  double dq;        // rad/s at the start
  double inertia;   // kg m^2, M_jj of the tree
  double external;  // N m, minus the bias: what gravity and motion of the others ask of the joint
  double warming;   // K above the start
};

/// The joint's part of (M + diag(added)) Ddq = impulse - h bias + coupling friction, and the
/// coordinate friction acts on: y' = y0 + mobility f + coupling dq', with |f| limited by friction.
/// Rigid joints: y' = dq'.
struct JointPart {
  double added = 0.0;    // kg m^2, to the diagonal
  double impulse = 0.0;  // N m s
  double y0 = 0.0, mobility = 0.0, coupling = 1.0;
  double f_min = 0.0, f_max = 0.0;  // N m s, impulses friction can give
  bool two_mass = false;
  // N m: springs, cogging, stops, drag (for reports)
  double passive_torque = 0.0;
  double bristle_gain = 0.0, bristle_denominator = 1.0;  // to advance the bristle
};

JointPart transmission_step(const JointParams& joint, const ServoOutput& servo,
                            const JointInstant& at, const InnerState& inner);

/// Advances the inner states with the step's outcome: dq_end of the link, friction impulse f.
void finish_transmission(const JointParams& joint, const JointInstant& at, const JointPart& part,
                         double dq_end, double f, InnerState& inner);

/// Play or compliance are on: the motor is a mass of its own.
inline bool is_two_mass(const JointParams& joint) {
  return joint.backlash > 0.0 || joint.compliance > 0.0;
}
/// The joint remembers more than position and velocity.
bool has_memory(const JointParams& joint);

}  // namespace sanso::diagnose
