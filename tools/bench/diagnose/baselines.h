// Simpler methods on the same cases, all on the linear first look that the diagnosis itself starts
// from (signatures of every effect, starts eliminated, nuisances fitted within their tolerances),
// so that they differ in the decision only.
// Each selects its size on held-out groups of recordings, as the diagnosis does, and returns the
// effects that it names.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/run/diagnose.h"

namespace sanso::bench {

/// Effect ids, the most certain first.
using Names = std::vector<std::string>;

// FirstLook::by_group must be filled.

/// The largest screening score alone, if held-out groups are predicted better with it.
Names largest_score(const diagnose::FirstLook& look);
/// All amounts fitted at once; named are those above a threshold of t, and the threshold is the one
/// with which held-out groups are predicted best.
Names fit_everything(const diagnose::FirstLook& look);
/// Sparse regression: one term after the other by orthogonal matching pursuit, as many as predict
/// held-out groups.
Names sparse_regression(const diagnose::FirstLook& look);
/// The same with friction only: viscous, Coulomb, Stribeck, load, ... as a friction ladder climbs.
Names friction_ladder(const diagnose::FirstLook& look);

}  // namespace sanso::bench
