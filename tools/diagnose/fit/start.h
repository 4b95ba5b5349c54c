// Where a full fit of one more effect begins. Predictions are not convex in an effect's size (a
// delay moves a jump from one sample to the next), so sizes are tried along a line before the
// Gauss-Newton steps, and orders between those probed.
#pragma once

#include "tools/diagnose/fit/fit.h"
#include "tools/diagnose/fit/screen.h"

namespace sanso::diagnose {

/// Every third shot of many, and everything fits need of them, linearised at `model`: enough to
/// tell where a fit begins, which is most of the passes of a step. Few shots stay as they are.
Surroundings some_shots(const Surroundings& around, const Model& model);

/// `base` with `candidate` added, at the size that leaves the least error; nuisances at their null
/// (one at the end of its tolerance, which stood in for the effect, would stay there). `probe`: its
/// strongest probe; nullptr: the first one. Of an effect of several limits every choice of limits
/// that it probes is tried, and one more beside the best: the linear screening does not tell a
/// speed limit from one of acceleration, and many servos have both. An event is sought in the shots
/// of `around` that can show it.
Model best_start(const Surroundings& around, const Model& base, std::size_t candidate,
                 const ProbeScore* probe);

/// Two candidates at once, from the amounts that their probes promise together (fit/pairs.h). What
/// has a place, an order or an event stands last: those are searched for the last effect.
Model best_start(const Surroundings& around, const Model& base, const ProbeScore& a,
                 const ProbeScore& b);

}  // namespace sanso::diagnose
