// Ankle roll first, then hip yaw and hip roll, then the knee from its triangle; a distance out
// of reach is clamped.
#include "host/motion/make/leg_ik.h"

#include <algorithm>
#include <cmath>

namespace sanso::motion {
namespace {

using Geometry = LegGeometry;

math::Mat3 rot_x(double a) {
  math::Mat3 R;
  R << 1, 0, 0, 0, std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a);
  return R;
}
math::Mat3 rot_z(double a) {
  math::Mat3 R;
  R << std::cos(a), -std::sin(a), 0, std::sin(a), std::cos(a), 0, 0, 0, 1;
  return R;
}

}  // namespace

LegSolution solve_leg(int side, const math::Vec3& p_world_base, const math::Mat3& R_world_base,
                      const math::Vec3& p_world_foot, const math::Mat3& R_world_foot) {
  const double s = side_sign(side);
  const math::Vec3 hip =
      p_world_base +
      R_world_base * math::Vec3(Geometry::kHipX, s * Geometry::kHipY, Geometry::kHipZ);
  const math::Vec3 ankle = p_world_foot + R_world_foot * math::Vec3(Geometry::kAnkleX, 0, 0);

  // ankle roll: turns the leg plane until it holds the hip
  const math::Vec3 hip_in_foot = R_world_foot.transpose() * (hip - ankle);
  const double roll = -std::atan2(-hip_in_foot.y(), hip_in_foot.z());

  // R_base_foot without that roll = Rz(psi) Rx(phi) Ry(theta): hip yaw, hip roll, sum of the
  // pitches
  const math::Mat3 M = R_world_base.transpose() * R_world_foot * rot_x(roll).transpose();
  const double psi = std::atan2(-M(0, 1), M(1, 1));
  const double phi = std::asin(std::clamp(M(2, 1), -1.0, 1.0));
  const double theta = std::atan2(-M(2, 0), M(2, 2));

  // knee from the triangle thigh, shank, hip-ankle distance; then hip pitch from the direction of
  // that line
  const math::Vec3 v =
      (rot_z(psi) * rot_x(phi)).transpose() * R_world_base.transpose() * (ankle - hip);
  constexpr double l1 = Geometry::kThigh, l2 = Geometry::kShank;
  const double distance = std::clamp(v.norm(), std::abs(l1 - l2) + 1e-6, 0.999 * (l1 + l2));
  const double knee =
      std::acos(std::clamp((distance * distance - l1 * l1 - l2 * l2) / (2 * l1 * l2), -1.0, 1.0));
  const double hip_pitch =
      std::atan2(-v.x(), -v.z()) - std::atan2(l2 * std::sin(knee), l1 + l2 * std::cos(knee));
  const double ankle_pitch = theta - hip_pitch - knee;

  LegSolution solution;
  solution.reach = v.norm() / (l1 + l2);
  // signs of the joints' axes: pitch joints are mirrored between the legs
  solution.q << -psi, -phi, s * hip_pitch, s * knee, -s * ankle_pitch, roll;
  return solution;
}

}  // namespace sanso::motion
