// Since when what begins at an instant acts, over all of the recorded time. The search thins fast
// and long recordings and begins fits on a third of what is left: between two of its shots any
// instant says the same.
#pragma once

#include "tools/diagnose/compare/candidate.h"
#include "tools/diagnose/compare/problem.h"
#include "tools/diagnose/explain/search_state.h"

namespace sanso::diagnose {

struct Instant {
  double at = 0.0;               // s on the recordings' clocks; 0: from the beginning
  double low = 0.0, high = 0.0;  // the instants that leave as little, within chance
};

/// Of `model`'s effect at place `effect` the instant that leaves least, everything else as it is;
/// `parameter`: which of its parameters the instant is. `everything`: shots that leave out none of
/// the recorded time.
Instant best_instant(const Problem& everything, const Library& library, const Model& model,
                     std::size_t effect, std::size_t parameter);

/// Puts every accepted effect that begins at an instant to the best one, everything else fitted
/// again; nothing where SelectOptions::whole is not known.
void place_instants_anew(SearchState& state);

}  // namespace sanso::diagnose
