// Footsteps of the robot: the swings of the human clip, scaled, started from and ended in standing
// with parallel feet.
#pragma once

#include <array>
#include <vector>

#include "host/motion/mocap/contacts.h"
#include "host/motion/recipe.h"
#include "shared/math/so3.h"

namespace sanso::motion {

/// Of the weight, before the first lift and after the last landing.
inline constexpr double kTransfer_s = 0.6;

/// Scale factors from human to robot.
struct Scale {
  double length = 1.0;  // m robot per m human (without kx)
  double time = 1.0;    // s robot per s human
};
/// Lengths by the legs; times by the root of the hips' heights, times the recipe's kt.
Scale scale_for(const HumanMotion& human, const Recipe& recipe);

struct Swing {
  int side = kRight;
  double lift_s = 0.0, land_s = 0.0;            // robot time
  double clip_lift_s = 0.0, clip_land_s = 0.0;  // human time: where the height of the hips is read
  Eigen::Vector2d from{0, 0}, to{0, 0};         // ankle-roll origin on the ground   m
};

struct StepPlan {
  std::array<Eigen::Vector2d, 2> start;  // right, left
  std::vector<Swing> swings;             // in the order of lifting
  double swing_height_m = 0.0;
  double swing_sharpness = 3.0;  // of the rise: height ~ (4 u (1 - u))^sharpness
  // share of a swing, at either end, in which the foot only rises or sinks
  double swing_dwell = 0.0;
  double duration_s = 0.0;

  /// Foot frame origin at time t: on the ground or on its way. Level, heading +x.
  math::Vec3 foot_at(int side, double t) const;
  bool carries(int side, double t) const;
  /// Where the weight should be: sole centres of the carrying feet, moving over linearly in double
  /// support.
  Eigen::Vector2d support_at(double t, double inside_m) const;
  /// Human time that belongs to robot time t.
  double clip_time(double t) const;
};

/// Throws ClipError when the clip holds no step.
StepPlan plan_steps(const HumanMotion& human, const Recipe& recipe);

}  // namespace sanso::motion
