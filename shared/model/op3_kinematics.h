// Kinematics of the controlled OP3 in world axes: link poses, feet, sole corners, Jacobians, centre
// of mass, momentum.
// Plain and readable; the fast path of the dynamics has its own (kernel/leg.h), and tests hold the
// two together.
// Frames: world; base = body_link; link j + 1 is moved by joint j; foot = ankle-roll link (6 right,
// 12 left).
#pragma once

#include <Eigen/Core>

#include "shared/model/state_layout.h"
#include "shared/model/step_model.h"

namespace sanso::model {

using math::Mat3;
using math::Vec3;

enum Foot : int { kRightFoot = 0, kLeftFoot = 1 };
/// Index of the last body of a leg (of its sole): row of body tables.
constexpr int foot_body(int foot) { return foot == kRightFoot ? 6 : 12; }
/// Parent of body i (0 is the base).
constexpr int parent_body(int i) { return i == 1 || i == 7 ? 0 : i - 1; }

struct Kinematics {
  Mat3 R_world_link[kNumBodies];  // rotation of each link frame
  Vec3 p_world_link[kNumBodies];  // m, its origin
  Vec3 axis_world[kNumJoints];    // joint axes with their sign
};

/// Poses of all links for a state. Cost: 12 rotations; no allocation.
void forward_kinematics(const State& x, Kinematics& kin);

/// Corner of a sole in foot axes [m]; corner order as kernel/contact.h: front outer, back outer,
/// back inner, front inner.
Vec3 sole_corner_in_foot(int foot, int corner);
/// Centre of the four corners in foot axes [m].
Vec3 sole_centre_in_foot(int foot);
inline Vec3 point_in_world(const Kinematics& kin, int body, const Vec3& p_body) {
  return kin.p_world_link[body] + kin.R_world_link[body] * p_body;
}

/// Jacobian of a body-fixed point: velocity in world axes = J (3 x 18) [v_base_in_world |
/// w_base_in_base | joint rates].
Eigen::Matrix<double, 3, kNv> point_jacobian(const Kinematics& kin, int body, const Vec3& p_world);
/// Jacobian of a body's angular velocity in world axes, same columns.
Eigen::Matrix<double, 3, kNv> rotation_jacobian(const Kinematics& kin, int body);

/// Centre of mass of the whole robot in world axes [m].
Vec3 centre_of_mass(const StepModel& model, const Kinematics& kin);

/// The symmetric upright stand of the public figures (base 0.2442 m above the sole, knees bent 65
/// deg), at rest on z = 0.
State standing_state();

}  // namespace sanso::model
