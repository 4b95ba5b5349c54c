// From the search's result to findings: names with parameters, rivals, refutations, and what could
// not be seen.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/diagnose/explain/regimes.h"
#include "tools/diagnose/explain/select.h"
#include "tools/diagnose/verdict/verdict.h"

namespace sanso::diagnose {

/// One finding for every accepted effect that no residual contradicts.
std::vector<Finding> findings_of(const Library& library, const Selection& selection,
                                 const Regimes& regimes);

/// Term bits (effects/effect.h) of a candidate on this tree. What a link does to a joint that hangs
/// on the base is a function of that joint's motion alone; further out, the motion of other joints
/// tells masses from springs and rotors.
unsigned terms_of(const Candidate& candidate, const std::vector<TreeJoint>& tree);

/// The final intervals (wider than those by which a name is accepted) of all that was fitted
/// contain the null.
bool spans_null(const Candidate& candidate,
                const std::map<std::string, VerdictParameter>& parameters);

/// Share of the nominal model's held-out error beyond noise that the final model still has, in [0,
/// 1].
double remaining_share(const Problem& problem, const Selection& selection);

/// Effects whose typical size these data could not show, and the smallest size that they would have
/// shown.
void add_limits(Verdict& verdict, const Library& library, const Selection& selection);

}  // namespace sanso::diagnose
