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

/// Searched, not fitted: when something begins, or how long it lasts.
bool is_instant(const CandidateParameter& p);

/// s: the sampling interval of the slowest recording.
double longest_row(const Comparison& comparison);

/// What not knowing the instants adds to a covariance of `fit` (coordinates of FitResult::J): they
/// were searched, not fitted, and a later push is a shorter and stronger one. The data count 1 /
/// `inflation` as in robust_covariance(). 0 for instants that no shot shows.
///
///   S = (T'MT - T'MJ H^-1 J'MT + 1 / shot^2)^-1,   K = -H^-1 J'MT,   result  [K; I] S [K; I]'
///
/// T = d r / d instant by central differences over a row, H = J'MJ + prior.
Eigen::MatrixXd spread_of_instants(const Surroundings& around, const FitResult& fit,
                                   double inflation);

/// Of `model`'s effect at place `effect` the instant that leaves least, everything else as it is;
/// `parameter`: which of its parameters the instant is. `everything`: shots that leave out none of
/// the recorded time.
Instant best_instant(const Problem& everything, const Library& library, const Model& model,
                     std::size_t effect, std::size_t parameter);

/// Puts every accepted effect that begins at an instant to the best one, everything else fitted
/// again; nothing where SelectOptions::whole is not known.
void place_instants_anew(SearchState& state);

}  // namespace sanso::diagnose
