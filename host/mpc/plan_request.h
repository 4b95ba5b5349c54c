// What one plan starts from.
#pragma once

#include <cstdint>

#include "shared/base/time.h"
#include "shared/policy/policy_types.h"

namespace sanso::mpc {

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
