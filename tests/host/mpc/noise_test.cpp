// The noise term against Monte Carlo: the cost that iLQG expects is the mean cost of many noisy
// roll-outs.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "host/mpc/noise_phases.h"
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

/// Which noise is planned with and sampled: F = f(x, u) ⊖ f(x, u without u_up) with w independent
/// per coordinate or one number, dF/dx planned with or not; or what models differ by.
struct Kind {
  const char* name;
  NoiseSettings noise;
};
constexpr Kind kByCoordinate{"a channel a coordinate", {}},
    kOneChannel{"one channel", {.one_noise_channel = true}},
    kByCoordinateSloped{"a channel a coordinate, dF/dx", {.input_slope = true}},
    kOneChannelSloped{"one channel, dF/dx", {.input_slope = true, .one_noise_channel = true}},
    kModels{"four models", {.spread = 1.0}};

/// The nominal robot, and four beside it drawn within a tenth: what a first fit leaves open.
host::AugmentedModel with_models() {
  host::AugmentedModel out;
  std::mt19937 random(17);
  std::normal_distribution<double> normal;
  for (int e = 0; e < 4; ++e) {
    model::ModelParameters p = model::nominal_parameters();
    const double heavier = std::exp(0.1 * normal(random)), softer = std::exp(0.1 * normal(random));
    for (auto& body : p.body) body.mass *= heavier;
    for (auto& servo : p.servo) servo.stiffness /= softer;
    out.spread.push_back(model::make_step_model(p));
  }
  return out;
}

/// Cost of the policy under x' = f(x, u) ⊕ sigma F w.
/// Each sample is paired with its mirror image -w, which removes the part of the scatter that is
/// odd in w.
Sampled monte_carlo(const reference::Model& m, const std::vector<reference::Model>& members,
                    const Solver& solver, double sigma, const Kind& kind, int pairs,
                    unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const Trajectory& t = solver.trajectory();
  double sum = 0, squares = 0;
  std::vector<Tangent> w(11);
  for (int pair = 0; pair < pairs; ++pair) {
    for (Tangent& noise : w) {
      noise = Tangent::NullaryExpr([&] { return normal(random); });
      if (kind.noise.one_noise_channel) noise.setConstant(noise[0]);
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
        const Tangent& noise = w[static_cast<std::size_t>(k)];
        Tangent moved = Tangent::Zero();
        if (members.empty()) {
          moved = model::minus(next, m.step(k, x, Input::Zero())).cwiseProduct(noise);
        } else {
          for (std::size_t e = 0; e < members.size(); ++e)
            moved += noise[static_cast<int>(e)] / std::sqrt(static_cast<double>(members.size())) *
                     model::minus(members[e].step(k, x, u), next);
        }
        x = model::plus(next, side * sigma * moved);
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

Noisy plan_and_sample(const char* motion, double sigma, const Kind& kind, int pairs) {
  const auto reference = problems::reference_of(motion);
  SpinPool pool(1, false);
  const host::AugmentedModel model = kind.noise.spread > 0 ? with_models() : host::AugmentedModel{};
  Op3Phases nominal({}, model, pool);
  NoiseSettings noise = kind.noise;
  noise.spread *= sigma;
  NoisePhases phases(noise, {}, nominal, pool);
  phases.set_model(model);
  const auto context = problems::make_context(reference, 50, 12, CostWeights{});
  nominal.context() = *context;
  SolverSettings settings;
  settings.convergence = 1e-7;
  settings.max_iterations = 60;
  settings.one_noise_channel = kind.noise.one_noise_channel;
  Solver solver(settings, phases);
  std::mt19937 random(3);
  const State x0 = model::plus(reference[50], problems::random_disturbance(random, 0.3));
  std::copy_n(x0.data(), kNx, solver.trajectory().x[0]);
  Noisy n;
  solver.solve(model.spread.empty() ? sigma : 0.0, 0, n.plan);
  const reference::Model m(model, *context, 0.06);
  std::vector<reference::Model> members;
  for (const model::StepModel& other : model.spread) {
    host::AugmentedModel member = model;
    member.analytical = other;
    members.emplace_back(member, *context, 0.06);
  }
  n.sampled = monte_carlo(m, members, solver, sigma, kind, pairs, 1);
  n.still = monte_carlo(m, members, solver, 0.0, kind, 1, 1);
  std::printf("%s, %s, sigma %.2f: deterministic %.5f, expected %.5f, sampled %.5f +- %.5f\n",
              motion, kind.name, sigma, n.plan.cost_after, n.plan.expected_cost, n.sampled.mean,
              n.sampled.error);
  return n;
}

TEST(Noise, ExpectedCostEqualsTheMeanOfNoisyRollOuts) {
  // small: the expected cost is a second-order law in sigma
  for (const Kind& kind : {kByCoordinate, kOneChannel, kByCoordinateSloped, kOneChannelSloped}) {
    const Noisy n = plan_and_sample("stand", 0.05, kind, 2500);
    EXPECT_NEAR(n.still.mean, n.plan.cost_after, 1e-6 * n.plan.cost_after);
    EXPECT_GT(n.noise(), 0);
    // three standard errors, and a fifth of the noise part for what the quadratic value function
    // leaves out: dF/dx where it is not planned with, kinks
    EXPECT_NEAR(n.sampled_noise(), n.noise(), 3 * n.sampled.error + 0.2 * n.noise());
  }
}

TEST(Noise, HoldsAtTheAmplitudesOfASession) {
  for (const char* motion : {"stand", "walk_forward"})
    for (const double sigma : {0.1, 0.3, 0.7})
      for (const Kind& kind :
           {kByCoordinate, kOneChannel, kByCoordinateSloped, kOneChannelSloped, kModels}) {
        const Noisy n = plan_and_sample(motion, sigma, kind, 400);
        EXPECT_NEAR(n.plan.expected_cost, n.sampled.mean,
                    0.1 * n.sampled.mean + 3 * n.sampled.error)
            << motion << " " << sigma << " " << kind.name;
      }
}

}  // namespace
}  // namespace sanso::mpc
