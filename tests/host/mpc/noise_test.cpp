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

/// Cost of the policy under x' = f(x, u) ⊕ sigma F w, w independent per coordinate or one number,
/// F = f(x, u) ⊖ f(x, u without u_up).
/// Each sample is paired with its mirror image -w, which removes the part of the scatter that is
/// odd in w.
Sampled monte_carlo(const reference::Model& m, const Solver& solver, double sigma, bool one_channel,
                    int pairs, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const Trajectory& t = solver.trajectory();
  double sum = 0, squares = 0;
  std::vector<Tangent> w(11);
  for (int pair = 0; pair < pairs; ++pair) {
    for (Tangent& noise : w) {
      noise = Tangent::NullaryExpr([&] { return normal(random); });
      if (one_channel) noise.setConstant(noise[0]);
    }
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

/// The plan of one disturbed moment, and what it costs under its own noise.
struct Noisy {
  SolveResult plan;
  Sampled sampled, still;
  double noise() const { return plan.expected_cost - plan.cost_after; }
  double sampled_noise() const { return sampled.mean - still.mean; }
};

Noisy plan_and_sample(const char* motion, double sigma, bool one_channel, int pairs) {
  const auto reference = problems::reference_of(motion);
  SpinPool pool(1, false);
  const host::AugmentedModel model;
  Op3Phases phases({}, model, pool);
  const auto context = problems::make_context(reference, 50, 12, CostWeights{});
  phases.context() = *context;
  SolverSettings settings;
  settings.convergence = 1e-7;
  settings.max_iterations = 60;
  settings.one_noise_channel = one_channel;
  Solver solver(settings, phases);
  std::mt19937 random(3);
  const State x0 = model::plus(reference[50], problems::random_disturbance(random, 0.3));
  std::copy_n(x0.data(), kNx, solver.trajectory().x[0]);
  Noisy n;
  solver.solve(sigma, 0, n.plan);
  const reference::Model m(model, *context, 0.06);
  n.sampled = monte_carlo(m, solver, sigma, one_channel, pairs, 1);
  n.still = monte_carlo(m, solver, 0.0, one_channel, 1, 1);
  std::printf("%s, %s, sigma %.2f: deterministic %.5f, expected %.5f, sampled %.5f +- %.5f\n",
              motion, one_channel ? "one channel" : "a channel a coordinate", sigma,
              n.plan.cost_after, n.plan.expected_cost, n.sampled.mean, n.sampled.error);
  return n;
}

TEST(Noise, ExpectedCostEqualsTheMeanOfNoisyRollOuts) {
  // small: the expected cost is a second-order law in sigma
  for (const bool one_channel : {false, true}) {
    const Noisy n = plan_and_sample("stand", 0.05, one_channel, 2500);
    EXPECT_NEAR(n.still.mean, n.plan.cost_after, 1e-6 * n.plan.cost_after);
    EXPECT_GT(n.noise(), 0);
    // three standard errors, and a fifth of the noise part for what the quadratic value function
    // leaves out: dF/dx, kinks
    EXPECT_NEAR(n.sampled_noise(), n.noise(), 3 * n.sampled.error + 0.2 * n.noise());
  }
}

TEST(Noise, HoldsAtTheAmplitudesOfASession) {
  for (const char* motion : {"stand", "walk_forward"})
    for (const double sigma : {0.1, 0.3, 0.7})
      for (const bool one_channel : {false, true}) {
        const Noisy n = plan_and_sample(motion, sigma, one_channel, 400);
        EXPECT_NEAR(n.plan.expected_cost, n.sampled.mean,
                    0.1 * n.sampled.mean + 3 * n.sampled.error)
            << motion << " " << sigma << " " << one_channel;
      }
}

}  // namespace
}  // namespace sanso::mpc
