// One target a kind of motion (in place, one leg, gait), then the same solution of the whole
// body for all of them.
#include "host/motion/make/retarget.h"

#include <algorithm>
#include <cmath>

#include "host/motion/make/footsteps.h"
#include "host/motion/make/leg_ik.h"
#include "host/motion/make/minimum_jerk.h"
#include "host/motion/mocap/filter.h"
#include "shared/base/time.h"

namespace sanso::motion {
namespace {

double standing_height(const Recipe& recipe) {
  return recipe.kappa * LegGeometry::kLength + LegGeometry::kSoleBelowAnkle - LegGeometry::kHipZ;
}

math::Vec3 standing_foot(int side) {
  return {0.0, side_sign(side) * LegGeometry::kHipY, LegGeometry::kSoleBelowAnkle};
}

/// Cut, mirrored, filtered, and resampled so that one sample is one tick of the robot.
HumanMotion prepared(const HumanMotion& clip, const Recipe& recipe) {
  const int last =
      recipe.last_frame < 0 ? static_cast<int>(clip.frames.size()) - 1 : recipe.last_frame;
  HumanMotion part = cut(clip, recipe.first_frame, last);
  if (recipe.mirror) part = mirrored(part);
  if (part.loops) part = unrolled(part, recipe.loops);
  const Scale scale = scale_for(part, recipe);
  return smooth_and_resample(part, recipe.cutoff_Hz, kTick_s / scale.time);
}

void push_tick(BodyTarget& target, const std::array<math::Vec3, 2>& feet,
               const std::array<bool, 2>& carries, double height, const Eigen::Vector2d& ground) {
  target.p_world_foot.push_back(feet);
  target.carries.push_back(carries);
  target.base_height.push_back(height);
  target.ground.push_back(ground);
}

/// Feet stay, hips move: the clip runs between two standing phases, faded in and out over its first
/// and last second.
BodyTarget in_place_target(const HumanMotion& human, const Recipe& recipe) {
  constexpr double kFade_s = 1.0;
  const Scale scale = scale_for(human, recipe);
  // widths do not scale with leg length: sway by the spacing of the hips, not by the length of the
  // legs
  const double lateral = LegGeometry::kHipSpacing / human.hip_spacing();
  const double stand_z = human.frames.front().hips().z();
  const auto n = static_cast<int>(human.frames.size());
  // a man rarely stands in his own middle: the sway is taken about its mean
  const auto hips_between_feet = [](const HumanFrame& frame) {
    return frame.hips().y() - 0.5 * (frame.leg[kRight].ankle.y() + frame.leg[kLeft].ankle.y());
  };
  double mean_y = 0.0;
  for (const auto& frame : human.frames) mean_y += hips_between_feet(frame) / n;
  std::vector<double> y(n), z(n);
  for (int k = 0; k < n; ++k) {
    const HumanFrame& frame = human.frames[static_cast<std::size_t>(k)];
    const double weight =
        minimum_jerk(k * kTick_s / kFade_s) * minimum_jerk((n - 1 - k) * kTick_s / kFade_s);
    y[k] = weight * lateral * (hips_between_feet(frame) - mean_y);
    z[k] = weight * scale.length * recipe.kz * (frame.hips().z() - stand_z);
  }
  BodyTarget target;
  target.ground_is_com = true;
  const int stand = static_cast<int>(std::lround(recipe.stand_s / kTick_s));
  const std::array<math::Vec3, 2> feet = {standing_foot(kRight), standing_foot(kLeft)};
  for (int k = -stand; k < n + stand; ++k) {
    const bool moving = k >= 0 && k < n;
    push_tick(target, feet, {true, true}, standing_height(recipe) + (moving ? z[k] : 0.0),
              {LegGeometry::kSoleCentreX, moving ? y[k] : 0.0});
  }
  return target;
}

/// Composed, because no clip holds a lift-off: the weight goes over the right foot, the left one
/// along a blend to the clip's ankle-to-ankle vector, holds on that segment, and all goes back.
BodyTarget one_leg_target(const HumanMotion& human, const Recipe& recipe) {
  constexpr double kShift_s = 1.2, kLift_s = 1.2;
  const Scale scale = scale_for(human, recipe);
  const double shift_end = recipe.stand_s + kShift_s, lift_end = shift_end + kLift_s;
  const double hold_end = lift_end + recipe.hold_s, down_end = hold_end + kLift_s,
               back_end = down_end + kShift_s;
  // right foot: y < 0
  const double over_foot = -(LegGeometry::kHipY + LegGeometry::kSoleCentreY - recipe.zmp_inside_m);
  BodyTarget target;
  target.ground_is_com = true;
  const int ticks = static_cast<int>(std::lround((back_end + recipe.stand_s) / kTick_s));
  for (int k = 0; k <= ticks; ++k) {
    const double t = k * kTick_s;
    const double shifted =
        minimum_jerk((t - recipe.stand_s) / kShift_s) - minimum_jerk((t - down_end) / kShift_s);
    const double lifted =
        minimum_jerk((t - shift_end) / kLift_s) - minimum_jerk((t - hold_end) / kLift_s);
    const double place = std::clamp((t - lift_end) / recipe.hold_s, 0.0, 1.0);
    const auto frame =
        static_cast<std::size_t>(place * static_cast<double>(human.frames.size() - 1));
    const math::Vec3 lift =
        scale.length * recipe.lift_scale *
        (human.frames[frame].leg[kLeft].ankle - human.frames[frame].leg[kRight].ankle);
    std::array<math::Vec3, 2> feet = {standing_foot(kRight), standing_foot(kLeft)};
    // beside the standing foot: the scaled ankles would come closer than the soles are wide
    feet[kLeft] +=
        lifted * math::Vec3(lift.x(), std::max(lift.y() - LegGeometry::kHipSpacing, 0.0), lift.z());
    push_tick(target, feet, {true, lifted < 1e-6}, standing_height(recipe),
              {LegGeometry::kSoleCentreX, shifted * over_foot});
  }
  return target;
}

BodyTarget gait_target(const HumanMotion& human, const Recipe& recipe) {
  HumanMotion walk = aligned(human, recipe.heading_by_body);
  if (!recipe.heading_by_body && !walk.loops) walk = floor_levelled(walk);
  const StepPlan plan = plan_steps(walk, recipe);
  const Scale scale = scale_for(walk, recipe);
  std::vector<double> hip_height;
  double mean = 0.0;
  for (const auto& frame : walk.frames) {
    hip_height.push_back(frame.hips().z());
    mean += frame.hips().z() / static_cast<double>(walk.frames.size());
  }
  BodyTarget target;
  const int ticks = static_cast<int>(std::lround(plan.duration_s / kTick_s));
  for (int k = 0; k <= ticks; ++k) {
    const double t = k * kTick_s;
    const double bob = sample_at(hip_height, plan.clip_time(t) / walk.dt_s) - mean;
    const double moving = minimum_jerk((t - plan.swings.front().lift_s) / 0.5) *
                          minimum_jerk((plan.swings.back().land_s - t) / 0.5);
    push_tick(target, {plan.foot_at(kRight, t), plan.foot_at(kLeft, t)},
              {plan.carries(kRight, t), plan.carries(kLeft, t)},
              standing_height(recipe) + moving * scale.length * recipe.kz * bob,
              plan.support_at(t, recipe.zmp_inside_m));
  }
  return target;
}

}  // namespace

Retargeted retarget(const HumanMotion& clip, const Recipe& recipe) {
  const HumanMotion human = prepared(clip, recipe);
  switch (recipe.kind) {
    case MotionKind::in_place:
      return solve_body(in_place_target(aligned(human, true), recipe));
    case MotionKind::one_leg:
      return solve_body(one_leg_target(aligned(human, true), recipe));
    case MotionKind::gait:
      return solve_body(gait_target(human, recipe));
  }
  throw ClipError(clip.source + ": unknown kind of motion");
}

}  // namespace sanso::motion
