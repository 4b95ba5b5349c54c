// Drives whose effort is recorded in a unit of its own: the number between it and N m, from the
// links' known inertia and weight, before anything else is asked.
#pragma once

#include <optional>

#include "tools/diagnose/torque/judge.h"

namespace sanso::diagnose {

/// Scales the rows of every joint of unknown gain into N m where the data determine it. One entry
/// for every such joint, its value the scale that was applied.
std::vector<EffortGainFound> scale_unknown_gains(EffortDesign& design, const Settings& settings);

/// Column of the joint's gain among the nuisances; nothing: it has none.
std::optional<Eigen::Index> gain_column(const EffortDesign& design, const std::string& joint);

}  // namespace sanso::diagnose
