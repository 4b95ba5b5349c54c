// What the last model leaves: is it noise? Asked of nobody's candidates.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/diagnose/explain/select.h"
#include "tools/diagnose/explain/whole_time.h"
#include "tools/diagnose/verdict/predictability.h"

namespace sanso::diagnose {

/// A short stretch of a recording that the last model misses by far more than its other errors.
struct Stretch {
  std::string recording, where;
  double from = 0.0, until = 0.0;  // s, the recording's own clock
  double level = 0.0;              // RMS of the position error, noise levels
};

struct Remains {
  // of the nominal model's held-out error beyond noise, still there, in [0, 1]
  double share = 0.0;
  double level = 0.0;                    // position error, noise levels (position_error_level)
  std::vector<TorqueSample> missing;     // torque that the last model lacks, window by window
  std::vector<Predictability> torque;    // by joint: of `missing` from the joint's state
  std::vector<Predictability> velocity;  // likewise: velocity channel less the position's motion
  std::vector<Stretch> stretches;        // strongest first
  bool stretches_matter = false;         // they repeat, and are more than what matters
  std::optional<std::size_t> stretches_joint;  // where they are strongest
};

/// Asks every joint's missing torque and velocity channel, and all of the recorded time.
/// `sources`: the recordings with the motion as it was before the search.
/// Velocity channels that an accepted effect acts on are left out: what they show is in the model.
Remains what_is_left(const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
                     const Library& library, const Selection& selection, const WholeTime& whole,
                     unsigned long seed);

}  // namespace sanso::diagnose
