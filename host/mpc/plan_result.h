// How a plan ended and what it cost in time.
#pragma once

#include <cstdint>

#include "shared/base/time.h"

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

}  // namespace sanso::mpc
