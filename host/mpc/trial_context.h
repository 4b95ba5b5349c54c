// What plans are made for: the trial that runs.
#pragma once

#include <cstdint>
#include <span>

#include "host/mpc/cost.h"
#include "shared/policy/layer_sum.h"

namespace sanso::mpc {

/// What stays the same during a trial. The spans and the table must outlive the trial; nothing is
/// copied.
struct TrialContext {
  std::uint32_t trial_id = 0;
  // x_DMP, one per 10 ms tick from trial tick 0; held after its end.
  std::span<const model::State> reference;
  // Its joint angles are the primitives' input
  // (paper: u_DMP = q2_DMP).
  const policy::MiddleTable* middle = nullptr;  // null or empty: the middle layer is off
  // as the controller runs (upper: false plans all the same)
  policy::LayerSwitches on;
  policy::ReflexSettings reflex;
  // target in place of the primitives when the lower layer is off, rad
  model::Input u_rest = model::Input::Zero();
  CostWeights weights;
};

}  // namespace sanso::mpc
