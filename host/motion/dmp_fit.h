// Fits movement primitives to a trajectory: one ridge regression of the forcing term per degree of
// freedom.
#pragma once

#include "host/motion/trajectory.h"
#include "shared/policy/primitives.h"

namespace sanso::motion {

struct DiscreteFit {
  double basis_per_second = 10.0;  // facts: about 10 for slow motions, at least 25 in all
  double fade_start = 0.9;         // fraction of the duration where the forcing begins to fade
};

/// Discrete set over the whole trajectory, which has to be sampled at 10 ms and should end at rest.
/// Throws std::invalid_argument when it is not, is shorter than 0.1 s, or needs more than kMaxBasis
/// functions.
policy::PrimitiveSet fit_discrete(const Trajectory& trajectory, const DiscreteFit& options = {});

/// Rhythmic set of `num_basis` functions for one period: sample 0 and the last one are the same
/// phase, up to a drift.
/// The motion lasts `duration_s`. Throws std::invalid_argument like fit_discrete.
policy::PrimitiveSet fit_rhythmic(const Trajectory& one_period, int num_basis, double duration_s);

/// Plays the set for its whole duration: the samples at 10 ms, first and last included.
Trajectory play(const policy::PrimitiveSet& set);

}  // namespace sanso::motion
