// A plan: the policy, how the search for it ended, what it cost and in what time.
#pragma once

#include <cstdint>

#include "shared/base/status.h"
#include "shared/base/time.h"
#include "shared/policy/policy_types.h"

namespace sanso::mpc {

enum class StopReason : std::uint8_t {
  converged,  // an iteration gained less than the fraction `convergence`
  iteration_limit,
  deadline,    // the time budget was used up; the policy is the best one found
  no_descent,  // no step length lowered the cost at the largest regularization
};
constexpr const char* to_string(StopReason r) {
  switch (r) {
    case StopReason::converged:
      return "converged";
    case StopReason::iteration_limit:
      return "iteration limit";
    case StopReason::deadline:
      return "deadline";
    case StopReason::no_descent:
      return "no descent";
  }
  return "unknown";
}

/// Nanoseconds of wall clock, summed over the iterations. `backward` contains what of the
/// linearisation runs beside it.
struct PlanTiming {
  Nanoseconds total = 0, predict = 0, linearize = 0, backward = 0, line_search = 0;
};

/// A plan as it is handed to the session; belongs to the caller, who keeps it for the next one.
struct PlanResult {
  // ok, or out_of_range when the state or the roll-out is not finite
  Status status = Status::not_ready;
  // kMaxUpperKnots knots (u, x, K), first at plan_tick, dt_s apart
  policy::UpperPolicy policy;
  // deterministic cost of the start: u_up = 0, or the shifted last plan
  double cost_before = 0;
  double cost_after = 0;     // of the returned policy, same roll-out, same weights
  double expected_cost = 0;  // with the price of the noise
  double gain_norm = 0;      // largest Frobenius norm of the knots' K before the limit
  // iterations whose step was accepted or that proved convergence
  int iterations = 0;
  StopReason stop = StopReason::iteration_limit;
  PlanTiming timing;
  // predicted state at plan_tick, where the plan starts
  model::State x_plan = model::neutral_state();
};

}  // namespace sanso::mpc
