// Mean of robot minus primitive over the last moments of a failed trial; the change in sum is
// bounded.
#include "host/learn/layers/goal_adaptation.h"

#include <algorithm>
#include <cmath>

namespace sanso::learn {
namespace {

struct MeanDeviation {
  Eigen::Matrix<double, policy::kNumScalarPrimitives, 1> scalar =
      Eigen::Matrix<double, policy::kNumScalarPrimitives, 1>::Zero();
  // from the primitive's orientation to the robot's, world axes
  math::Vec3 rotation_world = math::Vec3::Zero();
};

/// Mean of robot minus primitive over the last `window_s` of the episode.
MeanDeviation mean_deviation(const Episode& episode, std::span<const model::State> reference,
                             double window_s) {
  const auto wanted = static_cast<std::size_t>(std::lround(window_s / to_seconds(kTickPeriod)));
  const std::size_t count = std::min(wanted, episode.ticks.size());
  MeanDeviation mean;
  for (std::size_t i = episode.ticks.size() - count; i < episode.ticks.size(); ++i) {
    const auto tick = static_cast<std::size_t>(std::max(episode.ticks[i].trial_tick, 0));
    const model::State& x = episode.ticks[i].x;
    const model::State& x_dmp = reference[std::min(tick, reference.size() - 1)];
    mean.scalar.head<3>() += model::base_position(x) - model::base_position(x_dmp);
    mean.scalar.tail<model::kNumJoints>() += model::joints(x) - model::joints(x_dmp);
    mean.rotation_world += math::quat_log(
        math::quat_multiply(model::base_quat(x), math::quat_conjugate(model::base_quat(x_dmp))));
  }
  if (count > 0) {
    mean.scalar /= static_cast<double>(count);
    mean.rotation_world /= static_cast<double>(count);
  }
  return mean;
}

math::Vec3 clamped_length(const math::Vec3& v, double longest) {
  const double n = v.norm();
  return n > longest ? math::Vec3(v * (longest / n)) : v;
}

}  // namespace

void adapt_goals(const Episode& failed, std::span<const model::State> reference,
                 const policy::PrimitiveSet& original, const GoalAdaptationSettings& settings,
                 policy::PrimitiveSet& set) {
  if (!settings.enabled || failed.ticks.empty() || reference.empty()) return;
  const MeanDeviation mean = mean_deviation(failed, reference, settings.window_s);
  for (int i = 0; i < policy::kNumScalarPrimitives; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double most = i < 3 ? settings.max_position_m : settings.max_angle_rad;
    const double least = i == 2 ? settings.max_lowering_m : most;
    const double start = original.scalar[k].goal;
    set.scalar[k].goal = std::clamp(set.scalar[k].goal + settings.rate * mean.scalar[i],
                                    start - least, start + most);
  }
  // orientation: the same step on the left (world axes), its total bounded as one rotation vector
  const math::Quat moved = math::quat_multiply(math::quat_exp(settings.rate * mean.rotation_world),
                                               set.orientation.goal);
  const math::Vec3 total =
      math::quat_log(math::quat_multiply(moved, math::quat_conjugate(original.orientation.goal)));
  set.orientation.goal = math::quat_normalized(math::quat_multiply(
      math::quat_exp(clamped_length(total, settings.max_angle_rad)), original.orientation.goal));
}

}  // namespace sanso::learn
