// Two effects proposed together. Where two are missing, the first may look contradicted alone, or
// take up half of the other, and neither is accepted for what it does by itself.
#pragma once

#include <functional>
#include <vector>

#include "tools/diagnose/fit/screen.h"

namespace sanso::diagnose {

/// Two candidates, each with the probe and the multiple of it that together explain most.
struct CandidatePair {
  ProbeScore first, second;  // `amount`: with the other one in place
  double promise = 0.0;      // energy that both remove, as far as the model is linear
  double p = 1.0;            // that noise alone promises as much in any of the pairs looked at
};

/// What two signatures with scores za, zb (signed) and correlation rho remove together: the least
/// squares of two regressors,
///
///   z' G^-1 z = (za^2 - 2 rho za zb + zb^2) / (1 - rho^2),   amounts G^-1 z
///
/// in units of the signatures' sizes; 0 where an amount that cannot be negative would be, or where
/// the two cannot be told apart (|rho| > alike).
struct TogetherPromise {
  double energy = 0.0, a = 0.0, b = 0.0;
};
/// `a_signed`, `b_signed`: whether the amount may be negative. `alike`: largest |rho| allowed.
TogetherPromise promise_together(double za, double zb, double rho, bool a_signed, bool b_signed,
                                 double alike);

/// The pairs that promise most, strongest first, at most `pairs` of the settings: at one place (or
/// one of them the robot's), neither a special case of the other, p below the family-wise level,
/// and the promise beyond the strongest single one by more than what chance adds to it
/// (critical^2). None promises less than `least_energy` (times linear_reach).
std::vector<CandidatePair> promising_pairs(const Settings& settings, const Library& library,
                                           const Screening& screening, double least_energy);

/// Pairs that promise, by the same linear law, nearly what `candidate` does alone, and more than
/// either of theirs does by more than chance; strongest first, at most `pairs` of the settings.
/// `allowed`: which pairs are asked.
std::vector<CandidatePair> pairs_in_place_of(
    const Settings& settings, const Library& library, const Screening& screening,
    std::size_t candidate, const std::function<bool(const Candidate&, const Candidate&)>& allowed);

}  // namespace sanso::diagnose
