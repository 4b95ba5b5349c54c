// Goals of the primitives move a little towards what the body did when a trial failed (paper,
// "lower layer"; the formula is a reading of its words, since it gives none). Successful trials
// leave them alone.
#pragma once

#include <span>

#include "host/learn/episodes/episode.h"
#include "shared/policy/primitives.h"

namespace sanso::learn {

struct GoalAdaptationSettings {
  bool enabled = true;
  double rate = 0.03;
  double window_s = 0.3;
  double max_position_m = 0.020;
  double max_angle_rad = 0.0873;
  double max_lowering_m = 0.010;

  constexpr void visit(auto&& field) {
    field("enabled", enabled, "yes or no", false, true, "goals adapt after a failed trial (paper)");
    field("rate", rate, "1", 0.0, 1.0,
          "share of the mean deviation; a failure is a few hundredths of what it showed");
    field("window_s", window_s, "s", 0.01, 10.0, "before the failure: what led to it");
    field("max_position_m", max_position_m, "m", 0.0, 0.2,
          "of the whole change since the motion file, an axis: half a foot's width");
    field("max_angle_rad", max_angle_rad, "rad", 0.0, 1.0,
          "5 deg, a joint and of the orientation's rotation vector");
    field("max_lowering_m", max_lowering_m, "m", 0.0, 0.2,
          "of the base: a goal that follows a fall down is no goal");
  }
};

/// g += rate * mean over the window of (robot - primitive), for base position, joints and
/// orientation, in `set`.
/// `original` is the motion file's set, from which the total change is bounded; `reference` is
/// x_DMP per tick.
void adapt_goals(const Episode& failed, std::span<const model::State> reference,
                 const policy::PrimitiveSet& original, const GoalAdaptationSettings& settings,
                 policy::PrimitiveSet& set);

}  // namespace sanso::learn
