// How long a search will take, told before it begins and again after every step.
#pragma once

#include <string>

#include "tools/diagnose/compare/candidate.h"
#include "tools/diagnose/compare/problem.h"

namespace sanso::diagnose {

/// Passes (every shot simulated once) of a search, counted from its loops.
struct Passes {
  double look = 0.0;  // the first screening, and finding nothing in it
  double name = 0.0;  // one more name: screening, fits of the rivals, everything anew around it
};
/// Nothing is simulated: counted from joints, nuisances, probes and the settings of the search.
Passes passes_of(const Comparison& comparison, const Library& library);

/// "about 3 s to look, about 5 s for every name, 6 names at most", from one pass that is timed.
std::string time_ahead(const Problem& problem, const Library& library);

}  // namespace sanso::diagnose
