// Simpler methods on the same cases, all on the linear first look that the diagnosis itself starts from (signatures of
// every effect, nuisances and starts eliminated), so that they differ in the decision only. Each returns the effects
// that it names.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/run/diagnose.h"

namespace sanso::bench {

/// Effect ids, the most certain first.
using Names = std::vector<std::string>;

/// The largest screening score alone, if it is beyond chance.
Names largest_score(const diagnose::FirstLook& look);
/// All amounts fitted at once; those whose 3-sigma interval excludes zero.
Names fit_everything(const diagnose::FirstLook& look);
/// Sparse regression: one term after the other by orthogonal matching pursuit, until none is beyond chance.
Names sparse_regression(const diagnose::FirstLook& look);
/// The same with friction only: viscous, Coulomb, Stribeck, load, ... as a friction ladder climbs.
Names friction_ladder(const diagnose::FirstLook& look);

}  // namespace sanso::bench
