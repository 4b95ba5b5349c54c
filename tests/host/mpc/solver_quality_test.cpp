// The fast solver reaches the optimum of a slow and careful one: double precision, central differences, tight contact.
#include "tests/host/mpc/solver_quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

namespace sanso::mpc {
namespace {

TEST(SolverQuality, ReachesTheSlowReferenceOnProblemsOfThreeMotions) {
  // SANSO_QUALITY_PROBLEMS=500 is the full comparison of docs/results/mpc.md (some minutes)
  const char* asked = std::getenv("SANSO_QUALITY_PROBLEMS");
  const unsigned count = asked != nullptr ? static_cast<unsigned>(std::atoi(asked)) : 6;
  std::vector<double> excess;
  for (unsigned seed = 1; seed <= count; ++seed) {
    const Quality q = compare_on_problem(seed);
    excess.push_back(q.ours / q.slow - 1);
    std::printf("seed %u: start %.4f ours %.4f (%d iterations) slow %.4f (%d iterations) excess %.2f %%\n", seed, q.start,
                q.ours, q.iterations, q.slow, q.slow_iterations, 100 * excess.back());
    EXPECT_LT(q.ours, q.start);
  }
  std::sort(excess.begin(), excess.end());
  const auto within = std::count_if(excess.begin(), excess.end(), [](double e) { return e < 0.01; });
  std::printf("within 1 %%: %ld of %u; median %.3f %%, worst %.2f %%\n", static_cast<long>(within), count,
              100 * excess[excess.size() / 2], 100 * excess.back());
  EXPECT_LT(excess[excess.size() / 2], 0.03);
}

}  // namespace
}  // namespace sanso::mpc
