// Analytic inverse kinematics of one OP3 leg. The hip acts as a spherical joint, the ankle as a
// universal joint.
#pragma once

#include <Eigen/Core>

#include "host/motion/mocap/human_motion.h"
#include "shared/math/so3.h"

namespace sanso::motion {

/// Lengths of the leg [m]; ROBOTIS OP3 URDF (shared/model/data).
struct LegGeometry {
  static constexpr double kThigh = 0.11015;
  static constexpr double kShank = 0.110;
  static constexpr double kLength = kThigh + kShank;
  // hip centre in base, y times side
  static constexpr double kHipX = 0.0001, kHipY = 0.035, kHipZ = -0.0285;
  // ankle centre in the foot (ankle-roll) frame
  static constexpr double kAnkleX = 0.0241;
  static constexpr double kSoleBelowAnkle = 0.0305;
  // in the foot frame, y times side
  static constexpr double kSoleCentreX = 0.024, kSoleCentreY = 0.0125;
  static constexpr double kHipSpacing = 2 * kHipY;
};

struct LegSolution {
  Eigen::Matrix<double, 6, 1> q;  // hip_yaw, hip_roll, hip_pitch, knee, ank_pitch, ank_roll  rad
  // |hip - ankle| over the straight leg; above 0.999 the pose was out of reach
  double reach = 0.0;
};

/// Joint angles that put the foot frame (origin of ankle roll) at p_world_foot, R_world_foot. Knee
/// never overextended.
LegSolution solve_leg(int side, const math::Vec3& p_world_base, const math::Mat3& R_world_base,
                      const math::Vec3& p_world_foot, const math::Mat3& R_world_foot);

}  // namespace sanso::motion
