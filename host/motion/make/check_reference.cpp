// The checks of a reference: servo speed, joint limits, reach, ZMP inside the soles, gap between
// the feet, clearance.
#include <algorithm>
#include <cmath>
#include <limits>

#include "host/motion/make/balance.h"
#include "host/motion/make/body_kinematics.h"
#include "host/motion/make/leg_ik.h"
#include "host/motion/make/retarget.h"
#include "host/motion/mocap/filter.h"
#include "shared/model/joints.h"

namespace sanso::motion {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Convex hull, counter-clockwise (Andrew's monotone chain).
std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  std::vector<Eigen::Vector2d> hull;
  for (int round = 0; round < 2; ++round) {
    const std::size_t start = hull.size();
    for (const auto& p : points) {
      while (hull.size() >= start + 2 &&
             cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

std::vector<double> zmp_margins(const Retargeted& motion) {
  const std::vector<ZmpSample> zmp = zmp_of(motion.trajectory);
  std::vector<double> margins;
  for (std::size_t k = 0; k < zmp.size(); ++k) {
    std::vector<Eigen::Vector2d> corners;
    const BodyPoints points = body_points(motion.trajectory.x[k]);
    for (int side : {kRight, kLeft}) {
      if (!motion.target.carries[k][side]) continue;
      for (const auto& corner : points.sole_corners(side)) corners.push_back(corner.head<2>());
    }
    if (!corners.empty()) margins.push_back(distance_inside_hull({zmp[k].x, zmp[k].y}, corners));
  }
  return margins;
}

/// Sideways gap of the soles where they overlap in x.
double feet_gap(const std::array<math::Vec3, 2>& feet) {
  constexpr double kLength = model::kSoleFront - model::kSoleBack;
  if (std::abs(feet[kLeft].x() - feet[kRight].x()) > kLength)
    return std::numeric_limits<double>::infinity();
  return feet[kLeft].y() - feet[kRight].y() + 2 * model::kSoleInner;
}

double lowest_swing_peak(const BodyTarget& target) {
  double lowest = std::numeric_limits<double>::infinity();
  for (int side : {kRight, kLeft}) {
    double peak = 0.0;
    for (std::size_t k = 0; k < target.carries.size(); ++k) {
      if (!target.carries[k][side]) {
        peak = std::max(peak, target.p_world_foot[k][side].z() - LegGeometry::kSoleBelowAnkle);
      } else if (peak > 0.0) {
        lowest = std::min(lowest, peak);
        peak = 0.0;
      }
    }
  }
  return std::isfinite(lowest) ? lowest : 0.0;
}

}  // namespace

double distance_inside_hull(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& points) {
  const std::vector<Eigen::Vector2d> hull = convex_hull(points);
  double inside = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d edge = (hull[(i + 1) % hull.size()] - hull[i]).normalized();
    inside = std::min(inside, cross(edge, p - hull[i]));
  }
  return inside;
}

ReferenceCheck check_reference(const Retargeted& motion) {
  ReferenceCheck check;
  check.reach = motion.reach;
  check.joint_margin_rad = std::numeric_limits<double>::infinity();
  check.feet_gap_m = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < motion.trajectory.x.size(); ++k) {
    const model::State& x = motion.trajectory.x[k];
    for (int j = 0; j < model::kNumJoints; ++j) {
      const double speed = std::abs(x[model::kXJointRate + j]);
      if (speed > check.peak_joint_speed) {
        check.peak_joint_speed = speed;
        check.fastest_joint = model::kJoints[j].name;
      }
      const double q = x[model::kXJoint + j];
      check.joint_margin_rad = std::min({check.joint_margin_rad, q - model::kJoints[j].lower_rad,
                                         model::kJoints[j].upper_rad - q});
    }
    check.feet_gap_m = std::min(check.feet_gap_m, feet_gap(motion.target.p_world_foot[k]));
  }
  const std::vector<double> margins = zmp_margins(motion);
  check.zmp_margin_worst_m = *std::min_element(margins.begin(), margins.end());
  check.zmp_margin_p5_m = percentile(margins, 0.05);
  check.lowest_swing_peak_m = lowest_swing_peak(motion.target);
  return check;
}

}  // namespace sanso::motion
