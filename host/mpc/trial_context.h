// What a plan is made for: the trial that runs, and the state it starts from.
#pragma once

#include <cstdint>
#include <span>

#include "host/mpc/cost.h"
#include "shared/base/time.h"
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

/// What one plan starts from.
struct PlanRequest {
  std::int32_t observed_tick = 0;  // trial tick at which x_observed was true
  model::State x_observed = model::neutral_state();
  // trial tick of the policy's first knot, >= observed_tick
  std::int32_t plan_tick = 0;
  // what the controller runs until plan_tick; null: nothing
  const policy::UpperPolicy* in_use = nullptr;
  std::uint32_t sequence = 0;   // goes into the policy
  double sigma = -1.0;          // noise amplitude; negative: the setting's
  Nanoseconds time_budget = 0;  // from the call of plan(); 0: none
};

}  // namespace sanso::mpc
