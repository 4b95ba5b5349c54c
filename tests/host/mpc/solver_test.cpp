// The solver on a problem with a known answer: linear dynamics, quadratic cost. One step is the
// optimum.
#include "host/mpc/solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace sanso::mpc {
namespace {

/// x' = A x + B u on the vector parts of the state (orientation stays put), cost sum of |x|^2 w +
/// |u|^2, as the solver sees it.
class LinearPhases : public Phases {
 public:
  explicit LinearPhases(unsigned seed, int stages) : stages_(stages) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    for (int i = 0; i < kNdx; ++i)
      for (int j = 0; j < kColumns; ++j)
        AB_[i][j] = fixed(i) || fixed(j) ? 0.0 : 0.1 * normal(random) + (i == j);
  }
  int stages() const override { return stages_; }

  void linearize(const Trajectory& nominal, StageDerivatives* d, StageCost* c) override {
    for (int k = 0; k <= stages_; ++k) {
      c[k] = StageCost{};
      for (int i = 0; i < kNdx; ++i) {
        c[k].lx[i] = fixed(i) ? 0 : 2 * nominal.x[k][state_row(i)];
        c[k].lxx_diagonal[i] = 2;
      }
      if (k == stages_) break;
      std::copy(&AB_[0][0], &AB_[0][0] + kNdx * kColumns, &d[k].AB[0][0]);
      for (int i = 0; i < kNdx; ++i) {
        d[k].F[i] = 0;
        for (int j = 0; j < kNu; ++j) d[k].F[i] += AB_[i][kNdx + j] * nominal.u[k][j];
      }
      for (int i = 0; i < kNu; ++i) c[k].lu[i] = 2 * nominal.u[k][i], c[k].luu_diagonal[i] = 2;
    }
  }

  void roll_out(const LinePolicy& p, const double* steps, LaneTrajectories& out) override {
    ++roll_outs;
    for (int lane = 0; lane < kLineSearchLanes; ++lane) {
      double x[kNx], cost = 0, noise = 0;
      std::copy(p.nominal->x[0], p.nominal->x[0] + kNx, x);
      for (int k = 0; k <= stages_; ++k) {
        for (int i = 0; i < kNx; ++i) out.x(k, i, lane) = x[i];
        for (int i = 0; i < kNdx; ++i) cost += fixed(i) ? 0 : x[state_row(i)] * x[state_row(i)];
        if (k == stages_) break;
        double u[kNu], next[kNdx];
        for (int i = 0; i < kNu; ++i) {
          u[i] = p.nominal->u[k][i];
          if (p.gains) {
            u[i] += steps[lane] * p.gains[k].k[i];
            for (int j = 0; j < kNdx; ++j)
              if (!fixed(j))
                u[i] += p.gains[k].K[i][j] * (x[state_row(j)] - p.nominal->x[k][state_row(j)]);
          }
          u[i] = std::clamp(u[i], -p.input_limit_rad, p.input_limit_rad);
          out.u(k, i, lane) = u[i];
          cost += u[i] * u[i];
        }
        for (int i = 0; i < kNdx; ++i) {
          next[i] = 0;
          for (int j = 0; j < kNdx; ++j) next[i] += fixed(j) ? 0 : AB_[i][j] * x[state_row(j)];
          for (int j = 0; j < kNu; ++j) next[i] += AB_[i][kNdx + j] * u[j];
        }
        if (p.noise) noise += price(p.noise[k], u, p.nominal->u[k]);
        for (int i = 0; i < kNdx; ++i)
          if (!fixed(i)) x[state_row(i)] = next[i];
      }
      out.cost(lane) = std::isfinite(cost) ? cost : std::numeric_limits<double>::infinity();
      out.noise_cost(lane) = noise;
    }
  }

  int roll_outs = 0;

  static double price(const NoisePrice& n, const double* u, const double* nominal) {
    double sum = n.still;
    for (int i = 0; i < kNu; ++i) {
      sum += 2 * n.slope[i] * (u[i] - nominal[i]);
      for (int j = 0; j < kNu; ++j)
        sum += (u[i] - nominal[i]) * n.curvature[i][j] * (u[j] - nominal[j]);
    }
    return 0.5 * sum;
  }
  static bool fixed(int i) { return i >= kTheta && i < kTheta + 3; }
  static int state_row(int i) { return i < kTheta ? i : i + 1; }

 private:
  double AB_[kNdx][kColumns];
  int stages_;
};

void start(Solver& solver) {
  for (auto& row : solver.trajectory().u) std::fill(row, row + kNuPadded, 0.0);
  for (int i = 0; i < kNx; ++i) solver.trajectory().x[0][i] = 0.1 * std::sin(1.0 + i);
}

TEST(Solver, TakesOneFullStepOnALinearProblem) {
  LinearPhases phases(1, 11);
  SolverSettings settings;
  settings.input_limit_rad = 100;
  settings.regularization = 0;
  Solver solver(settings, phases);
  start(solver);
  SolveResult result;
  solver.solve(0.0, 0, result);
  EXPECT_EQ(result.stop, StopReason::converged);
  EXPECT_LE(result.iterations, 2);  // the optimum, and at most one that proves it
  // the optimum satisfies the first-order condition: V'(u) = 0 everywhere, so a second solve
  // changes nothing
  const double cost = result.cost_after;
  solver.solve(0.0, 0, result);
  EXPECT_NEAR(result.cost_after, cost, 1e-12 * cost);
}

TEST(Solver, ExpectedCostFallsWithEveryIterationUnderNoise) {
  LinearPhases phases(2, 11);
  SolverSettings settings;
  settings.input_limit_rad = 100;
  settings.convergence = 1e-9;
  Solver solver(settings, phases);
  double last = std::numeric_limits<double>::infinity();
  for (int limit = 1; limit <= 6; ++limit) {
    settings.max_iterations = limit;
    Solver limited(settings, phases);
    start(limited);
    SolveResult result;
    limited.solve(0.7, 0, result);
    EXPECT_LE(result.expected_cost, last * (1 + 1e-9));
    last = result.expected_cost;
  }
}

/// As LinearPhases, but from the second line search on every roll-out is dear: all proposals after
/// the first step are rejected.
class StubbornPhases : public LinearPhases {
 public:
  StubbornPhases(unsigned seed, int stages, int willing)
      : LinearPhases(seed, stages), willing_(willing) {}
  void roll_out(const LinePolicy& p, const double* steps, LaneTrajectories& out) override {
    LinearPhases::roll_out(p, steps, out);
    if (roll_outs <= willing_) return;
    for (int lane = 0; lane < kLineSearchLanes; ++lane) out.cost(lane) = 1e9;
  }

 private:
  int willing_;  // roll-outs, the start included
};

TEST(Solver, FeedbackOfARejectedProposalIsNeverLeft) {
  SolverSettings settings;
  settings.input_limit_rad = 100;
  settings.convergence = 0;
  LinearPhases willing(4, 11);
  settings.max_iterations = 1;
  Solver one_step(settings, willing);
  start(one_step);
  SolveResult result;
  one_step.solve(0.1, 0, result);
  ASSERT_EQ(result.iterations, 1);

  StubbornPhases stubborn(4, 11, 2);
  settings.max_iterations = 10;
  Solver solver(settings, stubborn);
  start(solver);
  solver.solve(0.1, 0, result);
  ASSERT_EQ(result.stop, StopReason::no_descent);
  ASSERT_EQ(result.iterations, 1);
  for (int k = 0; k < stubborn.stages(); ++k)
    for (int i = 0; i < kNu; ++i)
      for (int j = 0; j < kNdx; ++j)
        ASSERT_EQ(solver.gains()[k].K[i][j], one_step.gains()[k].K[i][j]) << k << " " << i;
}

TEST(Solver, WithoutAnyStepThereIsNoFeedback) {
  StubbornPhases phases(5, 11, 1);
  Solver solver(SolverSettings{}, phases);
  start(solver);
  SolveResult result;
  solver.solve(0.1, 0, result);
  ASSERT_EQ(result.stop, StopReason::no_descent);
  for (int k = 0; k < phases.stages(); ++k)
    for (const auto& row : solver.gains()[k].K)
      for (const double entry : row) EXPECT_EQ(entry, 0.0);
}

TEST(Solver, InputsStayInsideTheirLimitAndTheCostStillFalls) {
  LinearPhases phases(3, 11);
  SolverSettings settings;
  settings.input_limit_rad = 0.02;
  settings.max_iterations = 30;
  Solver solver(settings, phases);
  start(solver);
  SolveResult result;
  solver.solve(0.1, 0, result);
  EXPECT_LT(result.cost_after, result.cost_before);
  int at_limit = 0;
  for (int k = 0; k < 11; ++k)
    for (int i = 0; i < kNu; ++i) {
      EXPECT_LE(std::abs(solver.trajectory().u[k][i]), 0.02);
      at_limit += std::abs(solver.trajectory().u[k][i]) == 0.02;
    }
  EXPECT_GT(at_limit, 0) << "the limit was meant to matter";
}

TEST(Solver, StopsBeforeAnIterationThatWouldMissTheDeadline) {
  LinearPhases phases(4, 11);
  Solver solver({}, phases);
  start(solver);
  SolveResult result;
  solver.solve(0.0, steady_now() - 1, result);  // already over
  EXPECT_EQ(result.stop, StopReason::deadline);
  EXPECT_EQ(result.iterations, 0);
  // the start itself is always rolled out: it is the policy that is returned
  EXPECT_EQ(phases.roll_outs, 1);
  EXPECT_EQ(result.cost_after, result.cost_before);
}

TEST(Solver, SaysSoWhenTheStartIsNotFinite) {
  LinearPhases phases(5, 11);
  Solver solver({}, phases);
  start(solver);
  solver.trajectory().x[0][8] = std::nan("");
  SolveResult result;
  solver.solve(0.0, 0, result);
  EXPECT_FALSE(result.finite);
}

}  // namespace
}  // namespace sanso::mpc
