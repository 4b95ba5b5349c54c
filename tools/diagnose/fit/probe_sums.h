// What the probes of a candidate explain together.
#pragma once

#include "tools/diagnose/fit/screen.h"

namespace sanso::diagnose {

/// Fills ProbeScore::together of a screening that has scores and correlations. What can leave its
/// null in one direction only is no sum of probes.
Screening with_sums(const DecisionSettings& decisions, const Library& library, Screening out);

}  // namespace sanso::diagnose
