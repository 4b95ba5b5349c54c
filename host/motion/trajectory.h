// A motion of the whole body, sampled evenly: what retargeting produces and what primitives are
// fitted to.
#pragma once

#include <vector>

#include "shared/model/state_layout.h"

namespace sanso::motion {

struct Trajectory {
  double dt_s = 0.01;
  std::vector<model::State> x;  // sample k at k * dt_s

  /// From the first sample to the last.
  double duration_s() const { return x.empty() ? 0.0 : dt_s * static_cast<double>(x.size() - 1); }
};

/// Fills the velocities of every sample from the poses: central differences inside, one-sided at
/// the ends.
void differentiate_poses(Trajectory& trajectory);

}  // namespace sanso::motion
