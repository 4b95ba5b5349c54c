// Evaluates the general kinematics of shared/model once and picks the points.
#include "host/motion/make/body_kinematics.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace sanso::motion {
namespace {

math::Vec3 to_vec(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

}  // namespace

math::Vec3 BodyPoints::centre_of_mass() const {
  math::Vec3 sum = math::Vec3::Zero();
  double mass = 0.0;
  for (int b = 0; b < model::kNumBodies; ++b) {
    sum += model::kOp3Bodies[b].mass * p_world_com[b];
    mass += model::kOp3Bodies[b].mass;
  }
  return sum / mass;
}

std::array<math::Vec3, 4> BodyPoints::sole_corners(int side) const {
  const double s = side_sign(side);
  const double x[4] = {model::kSoleFront, model::kSoleBack, model::kSoleBack, model::kSoleFront};
  const double y[4] = {model::kSoleOuter, model::kSoleOuter, model::kSoleInner, model::kSoleInner};
  std::array<math::Vec3, 4> corners;
  for (int k = 0; k < 4; ++k) {
    corners[k] =
        p_world_foot[side] + R_world_foot[side] * math::Vec3(x[k], s * y[k], model::kSoleHeight);
  }
  return corners;
}

double BodyPoints::sole_height(int side) const {
  const auto corners = sole_corners(side);
  return std::min({corners[0][2], corners[1][2], corners[2][2], corners[3][2]});
}

BodyPoints body_points(const model::State& x) {
  BodyPoints points;
  const math::Vec3 p_world_base = model::base_position(x);
  const math::Mat3 R_world_base = math::rotation_matrix(model::base_quat(x));
  points.p_world_com[0] = p_world_base + R_world_base * to_vec(model::kOp3Bodies[0].com);
  for (int side : {kRight, kLeft}) {
    math::Vec3 p = p_world_base;
    math::Mat3 R = R_world_base;
    for (int k = 0; k < 6; ++k) {
      const int j = 6 * side + k;
      const model::JointGeometry& joint = model::kOp3Joints[j];
      p += R * to_vec(joint.origin);
      R = R * Eigen::AngleAxisd(joint.sign * x[model::kXJoint + j], math::Vec3::Unit(joint.axis))
                  .toRotationMatrix();
      points.p_world_com[j + 1] = p + R * to_vec(model::kOp3Bodies[j + 1].com);
      points.leg[side][k] = p;
    }
    points.p_world_foot[side] = p;
    points.R_world_foot[side] = R;
    points.leg[side][6] = p + R * math::Vec3(model::kSoleFront, 0, model::kSoleHeight);
  }
  return points;
}

}  // namespace sanso::motion
