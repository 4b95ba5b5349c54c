// The noise term against Monte Carlo: the cost that iLQG expects is the mean cost of many noisy
// roll-outs.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "host/mpc/op3_phases.h"
#include "host/mpc/solver.h"
#include "tests/host/mpc/support/problems.h"
#include "tests/host/mpc/support/reference_model.h"

namespace sanso::mpc {
namespace {

using model::Input;
using model::State;
using model::Tangent;

struct Sampled {
  double mean = 0, error = 0;  // error: standard deviation of the mean
};

/// Cost of the policy under x' = f(x, u) ⊕ sigma F w, w independent per coordinate, F = f(x, u) ⊖
/// f(x, u without u_up).
/// Each sample is paired with its mirror image -w, which removes the part of the scatter that is
/// odd in w.
Sampled monte_carlo(const reference::Model& m, const Solver& solver, double sigma, int pairs,
                    unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const Trajectory& t = solver.trajectory();
  double sum = 0, squares = 0;
  std::vector<Tangent> w(11);
  for (int pair = 0; pair < pairs; ++pair) {
    for (Tangent& noise : w) noise = Tangent::NullaryExpr([&] { return normal(random); });
    double cost = 0;
    for (const double side : {1.0, -1.0}) {
      State x = Eigen::Map<const State>(t.x[0]);
      for (int k = 0; k < 11; ++k) {
        const Tangent dx = model::minus(x, Eigen::Map<const State>(t.x[k]));
        Input u = Eigen::Map<const Input>(t.u[k]);
        for (int i = 0; i < kNu; ++i)
          for (int j = 0; j < kNdx; ++j) u[i] += solver.gains()[k].K[i][j] * dx[j];
        cost += 0.5 * (m.cost(k, x) + m.cost(u));
        const State next = m.step(k, x, u);
        const Tangent F = model::minus(next, m.step(k, x, Input::Zero()));
        x = model::plus(next, side * sigma * F.cwiseProduct(w[static_cast<std::size_t>(k)]));
      }
      cost += 0.5 * m.cost(11, x);
    }
    sum += cost;
    squares += cost * cost;
  }
  const double mean = sum / pairs;
  return {mean, std::sqrt((squares / pairs - mean * mean) / pairs)};
}

TEST(Noise, ExpectedCostEqualsTheMeanOfNoisyRollOuts) {
  const auto reference = problems::reference_of("stand");
  SpinPool pool(1, false);
  const host::AugmentedModel model;
  Op3Phases phases({}, model, pool);
  const auto context = problems::make_context(reference, 50, 12, CostWeights{});
  phases.context() = *context;
  SolverSettings settings;
  settings.convergence = 1e-7;
  settings.max_iterations = 60;
  Solver solver(settings, phases);
  std::mt19937 random(3);
  const State x0 = model::plus(reference[50], problems::random_disturbance(random, 0.3));
  std::copy_n(x0.data(), kNx, solver.trajectory().x[0]);
  constexpr double kSigma = 0.05;  // small: the expected cost is a second-order law in sigma
  SolveResult result;
  solver.solve(kSigma, 0, result);
  const double noise = result.expected_cost - result.cost_after;
  const reference::Model m(model, *context, 0.06);
  const Sampled sampled = monte_carlo(m, solver, kSigma, 5000, 1);
  const Sampled still = monte_carlo(m, solver, 0.0, 1, 1);
  std::printf("deterministic %.6f, expected %.6f, sampled %.6f +- %.6f (10000 roll-outs)\n",
              result.cost_after, result.expected_cost, sampled.mean, sampled.error);
  EXPECT_NEAR(still.mean, result.cost_after, 1e-6 * result.cost_after);
  EXPECT_GT(noise, 0);
  // three standard errors, and a fifth of the noise part for what the quadratic value function
  // leaves out: dF/dx, kinks
  EXPECT_NEAR(sampled.mean - still.mean, noise, 3 * sampled.error + 0.2 * noise);
}

}  // namespace
}  // namespace sanso::mpc
