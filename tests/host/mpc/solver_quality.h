// Our solver against the slow reference on one drawn problem.
#pragma once

#include <cstdio>

#include "host/mpc/op3_phases.h"
#include "host/mpc/solver.h"
#include "tests/host/mpc/support/problems.h"
#include "tests/host/mpc/support/reference_model.h"

namespace sanso::mpc {

struct Quality {
  double start = 0;         // cost of u_up = 0
  double ours = 0;          // our policy, closed loop under the tight model
  double own = 0;           // what our solver believes it costs, in its own model
  double slow = 0;          // the slow reference's optimum, same model
  double slow_stopped = 0;  // the slow reference, stopped by our convergence test
  int iterations = 0, slow_iterations = 0;
};

/// How hard our solver works: as in the product, or with what makes it slow and exact.
struct Effort {
  Op3PhasesSettings linearization;
  model::ContactSettings contact = host::AugmentedModel{}.analytical.contact;
  double convergence = SolverSettings{}.convergence;
  int max_iterations = SolverSettings{}.max_iterations;
};
inline Effort tight_effort() {
  Effort e;
  e.contact.sweeps = 200;
  e.convergence = 1e-6;
  e.max_iterations = 30;
  return e;
}

/// `seed` draws motion, moment and disturbance.
inline Quality compare_on_problem(unsigned seed, const Effort& effort = {}) {
  static const char* const kMotions[] = {"stand", "squat", "walk_forward"};
  std::mt19937 random(seed);
  const auto reference = problems::reference_of(kMotions[seed % 3]);
  const int tick =
      static_cast<int>(std::uniform_int_distribution<std::size_t>(0, reference.size() - 1)(random));
  host::AugmentedModel model;
  model.analytical.contact = effort.contact;
  SpinPool pool(1, false);
  Op3Phases phases(effort.linearization, model, pool, lane_kernels());
  const auto context = problems::make_context(reference, tick, 12, CostWeights{});
  phases.context() = *context;
  const model::State x0 =
      model::plus(reference[static_cast<std::size_t>(tick)], problems::random_disturbance(random));
  SolverSettings settings;
  settings.convergence = effort.convergence;
  settings.max_iterations = effort.max_iterations;
  Solver solver(settings, phases);
  std::copy_n(x0.data(), kNx, solver.trajectory().x[0]);
  SolveResult result;
  solver.solve(0.0, 0, result);

  Quality q;
  const host::AugmentedModel nominal;
  const reference::Model tight(nominal, *context, 0.06, 200);
  std::vector<model::State> x(12);
  std::vector<model::Input> u(11);
  std::vector<model::Gain> K(11);
  for (std::size_t k = 0; k < 12; ++k) {
    x[k] = Eigen::Map<const model::State>(solver.trajectory().x[k]);
    if (k == 11) break;
    u[k] = Eigen::Map<const model::Input>(solver.trajectory().u[k]);
    for (int i = 0; i < kNu; ++i)
      for (int j = 0; j < kNdx; ++j) K[k](i, j) = solver.gains()[k].K[i][j];
  }
  q.start = result.cost_before;
  q.ours = reference::closed_loop_cost(tight, x0, x, u, K, settings.input_limit_rad);
  const reference::Solution slow = reference::solve(tight, 11, x0, settings.input_limit_rad, 30);
  q.slow = slow.cost;
  q.slow_stopped = slow.cost_stopped(settings.convergence, settings.max_iterations);
  q.own = result.cost_after;
  q.iterations = result.iterations;
  q.slow_iterations = slow.iterations;
  return q;
}

}  // namespace sanso::mpc
