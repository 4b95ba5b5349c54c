// What the solver asks of a problem: whole phases, so that an implementation can use lanes and
// threads as it likes.
#pragma once

#include "host/mpc/noise_columns.h"

namespace sanso::mpc {

/// Step lengths tried in one roll-out, largest first.
alignas(64) inline constexpr double kStepLengths[kLineSearchLanes] = {1.0, 0.7, 0.5,  0.35,
                                                                      0.2, 0.1, 0.03, 0.01};

/// Roll-outs in step, lane by lane; a group has its own memory, so that two threads share no cache
/// line.
struct alignas(64) LaneGroup {
  double x[kMaxHorizon][kNxPadded][kRollOutLanes];
  double u[kMaxStages][kNuPadded][kRollOutLanes];
  double cost[kRollOutLanes];        // deterministic
  double noise_cost[kRollOutLanes];  // sum of the stages' noise prices
};

/// All roll-outs of a line search.
struct LaneTrajectories {
  LaneGroup group[kRollOutGroups];

  /// Component i of state, input and costs of one lane, wherever its group keeps it.
  double& x(int knot, int i, int lane) { return of(lane).x[knot][i][lane % kRollOutLanes]; }
  double& u(int stage, int i, int lane) { return of(lane).u[stage][i][lane % kRollOutLanes]; }
  double& cost(int lane) { return of(lane).cost[lane % kRollOutLanes]; }
  double& noise_cost(int lane) { return of(lane).noise_cost[lane % kRollOutLanes]; }
  LaneGroup& of(int lane) { return group[lane / kRollOutLanes]; }
};

/// The policy to roll out, u = clamp(ū + step k + K (x ⊖ x̄)), and how the noise it makes is
/// priced.
struct LinePolicy {
  const Trajectory* nominal = nullptr;
  const StageGains* gains = nullptr;      // null: u = ū, x̄ is not read
  const NoisePrice* noise = nullptr;      // null: noise is not priced
  const ColumnsPrice* columns = nullptr;  // null: there are none
  double input_limit_rad = 0;
};

class Phases {
 public:
  virtual ~Phases() = default;
  virtual int stages() const = 0;  // steps, horizon - 1
  /// Forgets what was kept from one linearisation to the next: a plan hangs on no earlier one.
  virtual void begin_solve() {}
  /// Derivatives of every stage and cost models of every knot at `nominal`.
  virtual void linearize(const Trajectory& nominal, StageDerivatives* derivatives,
                         StageCost* costs) = 0;
  /// The same in parts, so that the backward pass can begin while threads still work: stages are
  /// ready from the last one on. wait_for() returns when a stage and its cost are,
  /// finish_linearize() when all are. The last knot's cost always is.
  virtual void begin_linearize(const Trajectory& nominal, StageDerivatives* derivatives,
                               StageCost* costs) {
    linearize(nominal, derivatives, costs);
  }
  virtual void wait_for(int stage) { (void)stage; }
  virtual void finish_linearize() {}
  /// Noise beside what F and B of the derivatives make, at noise amplitude `sigma`; of the last
  /// linearisation, from begin_linearize() on.
  virtual NoiseColumns noise_columns(double sigma) const {
    (void)sigma;
    return {};
  }
  /// All lanes start in nominal.x[0]. Lane i uses step length steps[i] (64-byte aligned). A lane
  /// that leaves the finite numbers gets an infinite cost.
  virtual void roll_out(const LinePolicy& policy, const double* steps, LaneTrajectories& out) = 0;
  /// The lane of the last roll-out that becomes the nominal trajectory: what it knows may start the
  /// next linearisation.
  virtual void lane_taken(int lane) { (void)lane; }
};

}  // namespace sanso::mpc
