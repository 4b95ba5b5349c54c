// The arithmetic around the dynamics step, a group of lanes at a time: one table of functions per
// instruction set.
// Lane arrays are [component][lane].
#pragma once

#include "host/mpc/backward_pass.h"
#include "host/mpc/phases.h"
#include "host/mpc/stage_context.h"

namespace sanso::mpc {

using LaneArray = double[kRollOutLanes];

/// Policy of one stage of the line search: u_up = clamp(ū + step k + K (x ⊖ x̄)).
struct LineStage {
  const double* x_nominal;  // null without gains
  const double* u_nominal;
  const StageGains* gains;  // null: u_up = ū
  const NoisePrice* noise;  // null: noise is not priced
  const double* steps;      // of the group's lanes
  double input_limit_rad;
};

/// Evaluations of one stage for its differences, forward steps along columns of [A | B]. Columns
/// that change the configuration come first, beside the nominal point; the others (height,
/// velocities, inputs) may share its mass matrix.
/// Base x and y (columns 0 and 1) need none where the ground is the same everywhere along them.
///   group 0: nominal, columns 3 .. 9;  1: columns 10 .. 17;  2: height, nominal, columns 18 .. 23;
///   3 .. 5: columns 24 .. 47
inline constexpr int kEvaluationLanes = 8;
inline constexpr int kEvaluationGroups = kColumns / kEvaluationLanes;
inline constexpr int kConfigurationGroups = 2;
struct alignas(64) StageEvaluations {
  double x[kEvaluationGroups][kNx][kEvaluationLanes];  // states, replaced by the steps' results
  double u[kEvaluationGroups][kNu][kEvaluationLanes];
};

struct StageFinish {
  const StageEvaluations* evaluations;
  const double* x;        // nominal state of the stage
  const double* u_total;  // nominal input of the step
  const double* u_without_upper;
  const double* next;           // the nominal step's result
  const double* without_upper;  // and without u_up
  // result of a step from farther along base x; null: the column is (1, 0, ..)
  const double* along_x;
  const double (*layer_slope)[kNdxPadded];  // d (middle + reflex) / dx (nu x ndx)
  const ResidualWeights* residual;
  KeptJacobian* jacobian;  // of the residual at this stage
  double difference_step;
  double half_step_s;  // from the stage to the middle of its step
};

struct LaneKernels {
  const char* name;  // "avx512", "avx2", "baseline"
  BackwardPassFn backward_pass;
  /// u_up of a group of lanes; adds the price of their noise to noise_cost.
  void (*line_inputs)(const LineStage&, const LaneArray* x, LaneArray* u_upper, double* noise_cost);
  /// Sum of the layers.
  void (*layer_inputs)(const StageContext&, const ReflexContext&, const LaneArray* x,
                       const LaneArray* u_upper, LaneArray* u);
  /// x_next <- x_next ⊕ share f_NN(x, u).
  void (*add_residual)(const ResidualWeights&, double share, const LaneArray* x, const LaneArray* u,
                       LaneArray* x_next);
  /// cost += ||x ⊖ x_ref||²_Wx (+ ||u_up||²_Wu when u_upper is given).
  void (*add_cost)(const ProblemContext&, int knot, const LaneArray* x, const LaneArray* u_upper,
                   double* cost);
  /// Nominal point and its perturbations; those of velocities share the middle of the step.
  void (*spread)(const double* x, const double* u_total, double difference_step, double half_step_s,
                 StageEvaluations&);
  /// Differences, residual network, slope of the other layers, noise direction.
  void (*finish_stage)(const StageFinish&, StageDerivatives&);
};

/// The table of the instruction set that the batch step uses (model::batch_isa): the widest this
/// processor runs, unless a test or a benchmark has chosen another.
const LaneKernels& lane_kernels();
/// All tables this processor runs.
int available_lane_kernels(const LaneKernels** out, int capacity);

}  // namespace sanso::mpc
