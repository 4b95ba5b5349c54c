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
  double rate = 0.03;             // gamma, share of the mean deviation
  double window_s = 0.3;          // before the failure
  double max_position_m = 0.020;  // of the whole change since the motion file, per axis
  double max_angle_rad = 0.0873;  // 5 deg, per joint and of the orientation's rotation vector
  double max_lowering_m = 0.010;  // of the base's height
};

/// g += rate * mean over the window of (robot - primitive), for base position, joints and
/// orientation, in `set`.
/// `original` is the motion file's set, from which the total change is bounded; `reference` is
/// x_DMP per tick.
void adapt_goals(const Episode& failed, std::span<const model::State> reference,
                 const policy::PrimitiveSet& original, const GoalAdaptationSettings& settings,
                 policy::PrimitiveSet& set);

}  // namespace sanso::learn
