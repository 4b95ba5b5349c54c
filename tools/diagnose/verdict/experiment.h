// What to record next: the setting or motion under which the candidates of a set would differ most
// (T-optimal design: the rival may refit its own parameters and the nuisances before the difference
// counts).
#pragma once

#include <optional>
#include <vector>

#include "tools/diagnose/explain/select.h"
#include "tools/diagnose/verdict/verdict.h"

namespace sanso::diagnose {

/// Tries every entry of the menu by simulation: the recorded motions again with half and double
/// gain, a payload, a tilted base, a higher supply; then the same with commands half as large, half
/// as fast, twice as fast. `sets`: for every finding the fitted alternatives that cannot be told
/// apart from it. Nothing when no finding has one, or no entry separates them.
std::optional<NextExperiment> next_experiment(const Problem& problem, const Library& library,
                                              const Selection& selection,
                                              const std::vector<Finding>& findings);

}  // namespace sanso::diagnose
