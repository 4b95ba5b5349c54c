// The layout of state, tangent and input of the controlled OP3: the only place where the orders are
// written (sizes and offsets as constants: dimensions.h).
//
// State x   (37) [p_world_base 0..2 | quat_world_base wxyz 3..6 | q 7..18 | v_base_in_world 19..21
// |
//                 w_base_in_base 22..24 | dq 25..36]                      m, -, rad, m/s, rad/s,
//                 rad/s
// Tangent d (36) [dp 0..2 | dtheta 3..5 | dq 6..17 | dv 18..20 | dw 21..23 | ddq 24..35], dtheta in
// base axes
// Input u   (12) target joint angles, rad, in the order of joints.h
// This is MuJoCo's qpos | qvel, so plant and peer need no permutation.
#pragma once

#include <Eigen/Core>

#include "shared/math/so3.h"
#include "shared/model/dimensions.h"

namespace sanso::model {

using State = Eigen::Matrix<double, kNx, 1>;
using Tangent = Eigen::Matrix<double, kNdx, 1>;
using Input = Eigen::Matrix<double, kNu, 1>;
using Gain = Eigen::Matrix<double, kNu, kNdx>;  // rad of target per unit of tangent

/// Parts of a state: quat_world_base; p_world_base [m]; joint angles [rad] and rates [rad/s].
inline math::Quat base_quat(const State& x) { return x.segment<4>(kXQuat); }
inline math::Vec3 base_position(const State& x) { return x.segment<3>(kXPos); }
inline auto joints(const State& x) { return x.segment<kNumJoints>(kXJoint); }
inline auto joint_rates(const State& x) { return x.segment<kNumJoints>(kXJointRate); }

/// Upright at the origin, all joints zero, at rest.
inline State neutral_state() {
  State x = State::Zero();
  x[kXQuat] = 1.0;
  return x;
}

/// x ⊕ d.
inline State plus(const State& x, const Tangent& d) {
  State y;
  y.segment<3>(kXPos) = x.segment<3>(kXPos) + d.segment<3>(kDPos);
  y.segment<4>(kXQuat) = math::quat_plus(x.segment<4>(kXQuat), d.segment<3>(kDTheta));
  y.segment<kNumJoints>(kXJoint) = x.segment<kNumJoints>(kXJoint) + d.segment<kNumJoints>(kDJoint);
  y.segment<kNv>(kXVel) = x.segment<kNv>(kXVel) + d.segment<kNv>(kDVel);
  return y;
}

/// a ⊖ b: the tangent d with b ⊕ d = a.
inline Tangent minus(const State& a, const State& b) {
  Tangent d;
  d.segment<3>(kDPos) = a.segment<3>(kXPos) - b.segment<3>(kXPos);
  d.segment<3>(kDTheta) = math::quat_minus(a.segment<4>(kXQuat), b.segment<4>(kXQuat));
  d.segment<kNumJoints>(kDJoint) = a.segment<kNumJoints>(kXJoint) - b.segment<kNumJoints>(kXJoint);
  d.segment<kNv>(kDVel) = a.segment<kNv>(kXVel) - b.segment<kNv>(kXVel);
  return d;
}

/// The state between a (s = 0) and b (s = 1): linear, orientation along the geodesic.
inline State interpolate(const State& a, const State& b, double s) {
  return plus(a, s * minus(b, a));
}

}  // namespace sanso::model
