// Forward pass over the link table, base outwards; Jacobians are sums over the links that one joint
// carries.
#include "shared/model/op3_kinematics.h"

#include <Eigen/Geometry>
#include <cmath>

#include "shared/model/joints.h"

namespace sanso::model {
namespace {

Vec3 vec(const double* v) { return {v[0], v[1], v[2]}; }

Mat3 axis_rotation(int axis, double angle) {
  Mat3 R = Mat3::Identity();
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  R(i, i) = R(j, j) = std::cos(angle);
  R(j, i) = std::sin(angle);
  R(i, j) = -R(j, i);
  return R;
}

}  // namespace

void forward_kinematics(const State& x, Kinematics& kin) {
  kin.R_world_link[0] = math::rotation_matrix(base_quat(x));
  kin.p_world_link[0] = base_position(x);
  for (int j = 0; j < kNumJoints; ++j) {
    const JointGeometry& g = kOp3Joints[j];
    const int child = j + 1, parent = parent_body(child);
    kin.p_world_link[child] = kin.p_world_link[parent] + kin.R_world_link[parent] * vec(g.origin);
    kin.R_world_link[child] =
        kin.R_world_link[parent] * axis_rotation(g.axis, g.sign * x[kXJoint + j]);
    kin.axis_world[j] = g.sign * kin.R_world_link[parent].col(g.axis);
  }
}

Vec3 sole_corner_in_foot(int foot, int corner) {
  const double side = foot == kRightFoot ? -1.0 : 1.0;
  const bool front = corner == 0 || corner == 3, outer = corner < 2;
  return {front ? kSoleFront : kSoleBack, side * (outer ? kSoleOuter : kSoleInner), kSoleHeight};
}

Vec3 sole_centre_in_foot(int foot) {
  return 0.5 * (sole_corner_in_foot(foot, 0) + sole_corner_in_foot(foot, 2));
}

Eigen::Matrix<double, 3, kNv> point_jacobian(const Kinematics& kin, int body, const Vec3& p_world) {
  Eigen::Matrix<double, 3, kNv> J = Eigen::Matrix<double, 3, kNv>::Zero();
  J.leftCols<3>().setIdentity();
  J.middleCols<3>(3) = -math::skew(p_world - kin.p_world_link[0]) * kin.R_world_link[0];
  for (int i = body; i > 0; i = parent_body(i))
    J.col(6 + i - 1) = kin.axis_world[i - 1].cross(p_world - kin.p_world_link[i]);
  return J;
}

Eigen::Matrix<double, 3, kNv> rotation_jacobian(const Kinematics& kin, int body) {
  Eigen::Matrix<double, 3, kNv> J = Eigen::Matrix<double, 3, kNv>::Zero();
  J.middleCols<3>(3) = kin.R_world_link[0];
  for (int i = body; i > 0; i = parent_body(i)) J.col(6 + i - 1) = kin.axis_world[i - 1];
  return J;
}

Vec3 centre_of_mass(const StepModel& model, const Kinematics& kin) {
  Vec3 moment = Vec3::Zero();
  for (int i = 0; i < kNumBodies; ++i)
    moment += model.body[i].mass * kin.p_world_link[i] +
              kin.R_world_link[i] * vec(model.body[i].first_moment);
  return moment / model.body[0].subtree_mass;
}

State standing_state() {
  // thigh, knee, ankle for a foot under the hip, left signs; right is the negative (mirror rule)
  constexpr double kDegree = kPi / 180.0;
  constexpr double thigh = 32.32 * kDegree, knee = 64.68 * kDegree, ankle = 32.36 * kDegree;
  State x = neutral_state();
  const double left[6] = {0, 0, -thigh, knee, ankle, 0};
  for (int j = 0; j < 6; ++j) {
    x[kXJoint + 6 + j] = left[j];
    x[kXJoint + j] = -left[j];
  }
  Kinematics kin;
  forward_kinematics(x, kin);
  x[kXPos + 2] = -point_in_world(kin, foot_body(kLeftFoot), sole_centre_in_foot(kLeftFoot))[2];
  return x;
}

}  // namespace sanso::model
