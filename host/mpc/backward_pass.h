// Backward pass of stochastic iLQG [Todorov & Li 2005] with input limits and multiplicative noise.
//
//   Qx = lx + A'Vx          Qu  = lu + B'Vx + sigma^2 B' W F
//   Qxx = lxx + A'Vxx A     Qux = B'Vxx A
//   Quu = luu + B'Vxx B + sigma^2 B' W B + mu I
//   k = -Quu^-1 Qu,  K = -Quu^-1 Qux  on the inputs that are not held at a limit
//
// The noise is x' = f + sigma F w. With one channel a tangent coordinate W = diag(Vxx); with a
// single channel, w a number and F one column of noise, W = Vxx. dF/du = B exactly, dF/dx is left
// out (zero at a cold start); noise columns (noise_columns.h) have it. The kernels are compiled
// once per instruction set; the choice is made at run time.
#pragma once

#include "host/mpc/noise_columns.h"

namespace sanso::mpc {

/// What the pass says about the step it proposes.
struct BackwardSummary {
  bool ok = false;  // false: Quu not positive definite (or not finite) at some stage
  // sum of k'Qu: predicted change of cost at alpha is alpha linear + alpha^2 quadratic
  double linear = 0;
  double quadratic = 0;  // sum of k'Quu k / 2
};

struct BackwardInput {
  int stages = 0;
  const StageDerivatives* derivatives = nullptr;  // [stages]
  // [stages + 1], the last one without an input part
  const StageCost* costs = nullptr;
  const double (*u)[kNuPadded] = nullptr;  // [stages] nominal upper input, rad
  double input_limit_rad = 0;
  double sigma = 0;
  bool one_noise_channel = false;
  const NoiseColumns* columns = nullptr;  // further noise; null: none
  double mu = 0;                          // added to the diagonal of Quu
  // called before a stage is read, from the last one on; may be null
  void (*wait_for)(void* context, int stage) = nullptr;
  void* wait_context = nullptr;
};

struct BackwardOutput {
  StageGains* gains = nullptr;      // [stages]
  NoisePrice* noise = nullptr;      // [stages] under the value of the knot after the stage
  ColumnsPrice* columns = nullptr;  // [stages] the same of the columns; null without
};

/// One instruction set's pass (lane_kernels.h has them all). `value` is scratch and ends as the
/// value function of the first knot.
using BackwardPassFn = BackwardSummary (*)(const BackwardInput&, const BackwardOutput&,
                                           Value& value);

}  // namespace sanso::mpc
