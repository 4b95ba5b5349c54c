// Chain of six rotations from hip to ankle; the velocity of the sole is the sum of the joints'
// parts, relative to the base.
#include "firmware/estimate/leg_kinematics.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "shared/model/op3_table.h"

namespace sanso::firmware {
namespace {

using math::Mat3;
using math::Vec3;

Mat3 axis_rotation(int axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const int j = (axis + 1) % 3, k = (axis + 2) % 3;
  Mat3 R = Mat3::Identity();
  R(j, j) = c;
  R(k, k) = c;
  R(j, k) = -s;
  R(k, j) = s;
  return R;
}

// sign of y of the left foot's figures
double inward(Leg leg) { return leg == kLeftLeg ? 1.0 : -1.0; }

}  // namespace

SoleKinematics sole_kinematics(Leg leg, const double* q, const double* dq,
                               const model::FootShape& foot) {
  SoleKinematics sole;
  std::array<Vec3, kJointsPerLeg> p_base_joint, axis_in_base;
  Vec3 p = Vec3::Zero();
  Mat3 R = Mat3::Identity();
  for (int j = 0; j < kJointsPerLeg; ++j) {
    const model::JointGeometry& joint = model::kOp3Joints[leg * kJointsPerLeg + j];
    p += R * Vec3(joint.origin[0], joint.origin[1], joint.origin[2]);
    p_base_joint[static_cast<std::size_t>(j)] = p;
    axis_in_base[static_cast<std::size_t>(j)] = joint.sign * R.col(joint.axis);
    R = R * axis_rotation(joint.axis, joint.sign * q[j]);
  }
  const Vec3 p_foot_sole(model::kSoleCentreX, inward(leg) * model::kSoleCentreY, foot.height);
  sole.p_base_sole = p + R * p_foot_sole;
  sole.R_base_sole = R;
  for (std::size_t j = 0; j < kJointsPerLeg; ++j) {
    sole.v_sole_in_base +=
        dq[j] * (math::skew(axis_in_base[j]) * (sole.p_base_sole - p_base_joint[j]));
    sole.w_sole_in_base += dq[j] * axis_in_base[j];
  }
  return sole;
}

double lowest_corner(const SoleKinematics& sole, const Vec3& up_in_base,
                     const model::FootShape& foot) {
  const Eigen::RowVector3d up_in_sole = up_in_base.transpose() * sole.R_base_sole;
  return up_in_base.dot(sole.p_base_sole) - foot.half_length * std::abs(up_in_sole[0]) -
         foot.half_width * std::abs(up_in_sole[1]);
}

}  // namespace sanso::firmware
