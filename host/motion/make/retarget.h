// From a human clip to a motion of base and joints together: feet, centre of mass, inverse
// kinematics, checks.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "host/motion/mocap/human_motion.h"
#include "host/motion/recipe.h"
#include "host/motion/trajectory.h"

namespace sanso::motion {

/// What the body has to do, tick by tick: the input of solve_body.
struct BodyTarget {
  // ankle-roll origins, right and left; feet heading +x   m
  std::vector<std::array<math::Vec3, 2>> p_world_foot;
  // about +y, heel up is positive; empty: level   rad
  std::vector<std::array<double, 2>> foot_pitch = {};
  std::vector<std::array<bool, 2>> carries;
  std::vector<double> base_height;  // m
  // wanted ZMP, or CoM when `ground_is_com`   m
  std::vector<Eigen::Vector2d> ground;
  bool ground_is_com = false;
};

struct Retargeted {
  Trajectory trajectory;  // at 10 ms, at rest at both ends
  BodyTarget target;
  double reach = 0.0;  // largest |hip - ankle| over the straight leg
};

/// Turned about +y.
math::Mat3 pitched(double rad);

/// Throws ClipError when the clip does not hold what the recipe asks for.
Retargeted retarget(const HumanMotion& clip, const Recipe& recipe);

/// Places the base so that the CoM follows the target (or has the target as its ZMP), and solves
/// the legs.
Retargeted solve_body(const BodyTarget& target);

/// What a reference has to fulfil before a robot sees it.
struct ReferenceCheck {
  double peak_joint_speed = 0.0;  // rad/s
  std::string fastest_joint;
  // distance of the ZMP from the edge of the support polygon; negative: outside
  double zmp_margin_worst_m = 0.0;
  double zmp_margin_p5_m = 0.0;   // 5th percentile
  double joint_margin_rad = 0.0;  // to the nearest joint limit
  double reach = 0.0;
  // smallest distance between the inner edges of the soles while beside each other
  double feet_gap_m = 0.0;
  double lowest_swing_peak_m = 0.0;  // highest point of the lowest swing
};
/// Of a motion on its own, before anything follows it.
ReferenceCheck check_reference(const Retargeted& motion);

inline constexpr double kMaxReferenceSpeed = 4.5;  // rad/s: XM430 no-load speed at 11.1 V
inline constexpr double kMaxReach = 0.99;

/// Distance of p from the edge of the convex hull of `points`; negative outside.   m
double distance_inside_hull(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& points);

}  // namespace sanso::motion
