// Stochastic iLQG: linearise, backward pass, roll-outs of all step lengths at once, until the cost
// stops falling.
//
// Merit of a roll-out: its deterministic cost plus the price of its noise, sigma^2/2 F'WF, with W
// of the backward pass that proposed the step and F = F̄ + B (u - ū): the same model of the noise
// that the backward pass minimises.
// Convergence test: an iteration lowers the merit by less than the fraction `convergence` of it.
#pragma once

#include <memory>

#include "host/mpc/backward_pass.h"
#include "host/mpc/phases.h"
#include "host/mpc/plan_result.h"

namespace sanso::mpc {

struct SolverSettings {
  int max_iterations = 12;
  double convergence = 2e-4;
  double regularization = 1e-6;
  double input_limit_rad = 0.5;
  bool one_noise_channel = false;
};

struct SolveResult {
  // false: even the start's roll-out left the finite numbers; nothing else is valid
  bool finite = false;
  double cost_before = 0;    // deterministic
  double cost_after = 0;     // deterministic
  double expected_cost = 0;  // with the price of the noise under the final policy
  int iterations = 0;        // steps taken
  StopReason stop = StopReason::iteration_limit;
  PlanTiming timing;
};

class Solver {
 public:
  Solver(const SolverSettings& settings, Phases& phases);

  /// From trajectory().x[0] and trajectory().u (the start: of its inputs the share, none to all,
  /// that costs least); leaves the best trajectory and its gains here.
  /// `deadline` is a steady-clock time, 0 none: no iteration starts that is not expected to end
  /// before it.
  void solve(double sigma, Nanoseconds deadline, SolveResult& result);

  Trajectory& trajectory() { return work_->trajectory; }
  const Trajectory& trajectory() const { return work_->trajectory; }
  /// Of the last step taken; zero when none was: feedback of a rejected proposal is never used.
  const StageGains* gains() const { return work_->taken; }
  const Value& value() const { return work_->value; }

 private:
  struct Workspace {
    Trajectory trajectory;
    StageDerivatives derivatives[kMaxStages];
    StageCost costs[kMaxHorizon];
    StageGains gains[kMaxStages];  // of the newest proposal
    StageGains taken[kMaxStages];  // of the last one that lowered the cost
    NoisePrice noise[kMaxStages];
    Value value;
    LaneTrajectories lanes;
    ColumnsPrice columns[kMaxStages];  // last: rarely used, and large
  };
  enum class Step { taken, too_small, none };

  bool roll_out_start(SolveResult& result);
  bool start_as_line();
  Step improve(double sigma, SolveResult& result);
  bool propose(double sigma, SolveResult& result);
  int try_step_lengths(SolveResult& result);
  int cheapest_lane() const;
  double noise_price() const;
  const ColumnsPrice* columns() const { return has_columns_ ? work_->columns : nullptr; }
  void take_lane(int lane);

  SolverSettings settings_;
  Phases& phases_;
  BackwardPassFn backward_pass_;
  double mu_ = 0;
  bool has_columns_ = false;  // the newest proposal has priced noise columns
  double cost_ = 0;           // deterministic, of trajectory()
  double noise_cost_ = 0;     // price of its noise, as the step that led to it was judged
  std::unique_ptr<Workspace> work_;
};

/// Monotonic clock of deadlines and timings.
Nanoseconds steady_now();

}  // namespace sanso::mpc
