// The fast solver reaches the optimum of a slow and careful one: double precision, central
// differences, tight contact.
#include "tests/host/mpc/solver_quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace sanso::mpc {
namespace {

unsigned number(const char* variable, unsigned otherwise) {
  const char* asked = std::getenv(variable);
  return asked != nullptr ? static_cast<unsigned>(std::atoi(asked)) : otherwise;
}

long within(const std::vector<double>& excess, double limit) {
  return std::count_if(excess.begin(), excess.end(), [&](double e) { return e < limit; });
}

/// Excess of our cost over the reference's, sorted. SANSO_QUALITY_PROBLEMS=500 is the full
/// comparison of docs/results/mpc.md (half an hour of one core); SANSO_QUALITY_FIRST=101 begins
/// with another seed, so that several processes can share the work.
std::vector<double> excess_on_problems(const Effort& effort) {
  const unsigned first = number("SANSO_QUALITY_FIRST", 1),
                 count = number("SANSO_QUALITY_PROBLEMS", 12);
  std::vector<double> excess, excess_stopped;
  for (unsigned seed = first; seed < first + count; ++seed) {
    const Quality q = compare_on_problem(seed, effort);
    excess.push_back(q.ours / q.slow - 1);
    excess_stopped.push_back(q.ours / q.slow_stopped - 1);
    std::printf(
        "seed %u: start %.4f ours %.4f (%d iterations, own model %.4f) slow %.4f (%d iterations; "
        "%.4f by our "
        "convergence test) excess %.2f %%\n",
        seed, q.start, q.ours, q.iterations, q.own, q.slow, q.slow_iterations, q.slow_stopped,
        100 * excess.back());
    std::fflush(stdout);
    EXPECT_LT(q.ours, q.start);
  }
  std::sort(excess.begin(), excess.end());
  std::printf("within 1 %%: %ld of %u; median %.3f %%, worst %.2f %%\n", within(excess, 0.01),
              count, 100 * excess[excess.size() / 2], 100 * excess.back());
  std::printf(
      "of the reference stopped by our convergence test: within 1 %%: %ld of %u, more than 1 %% "
      "better: %ld\n",
      within(excess_stopped, 0.01), count, within(excess_stopped, -0.01));
  return excess;
}

// 94 % of problems within 1 % of the reference are wanted, of a drawn sample at least that share
// less three standard deviations. Of 500 it is 88 % since the midpoint step (docs/results/mpc.md,
// "Today"), so that many fail here; twelve cannot tell.
TEST(SolverQuality, TheProductReachesTheSlowReference) {
  const std::vector<double> excess = excess_on_problems({});
  const double n = static_cast<double>(excess.size()), share = 0.94;
  EXPECT_GE(static_cast<double>(within(excess, 0.01)),
            share * n - 3 * std::sqrt(n * share * (1 - share)));
  EXPECT_LT(excess[excess.size() / 2], 0.003);
}

// The same algorithm with the reference's contact work, difference and stopping fraction: what is
// left is the algorithm's own error. One of the first sixty problems ends in a worse minimum
// (docs/results/mpc.md), none of these.
TEST(SolverQuality, WithTheReferencesWorkItReachesTheReference) {
  const std::vector<double> excess = excess_on_problems(tight_effort());
  EXPECT_LT(excess[excess.size() / 2], 0.001);
  EXPECT_LT(excess[excess.size() * 9 / 10], 0.01);
}

}  // namespace
}  // namespace sanso::mpc
