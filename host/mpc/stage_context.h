// What the other layers, the reference and the model contribute to one planning problem, sampled
// once per plan.
// Plain arrays: read by the kernels of every instruction set.
#pragma once

#include "host/mpc/problem.h"
#include "host/mpc/residual_weights.h"
#include "shared/policy/layer_kernels.h"

namespace sanso::mpc {

/// Middle and lower layer during one step: u = u_up + u_fixed + K_middle (x ⊖ x_middle) +
/// reflex(q).
struct alignas(64) StageContext {
  double u_fixed[kNuPadded];         // u_mid + primitives at the middle of the step, rad
  double K_middle[kNu][kNdxPadded];  // at the middle of the step
  double x_middle[kNxPadded];        // at its beginning, where x is compared with it
  bool has_middle;
};

struct ReflexContext {
  bool on;
  policy::ReflexSettings settings;
  double lower[kNu], upper[kNu];  // joint limits, rad
};

struct alignas(64) ProblemContext {
  StageContext stage[kMaxStages];
  double x_ref[kMaxHorizon][kNxPadded];
  double state_weight[kNdxPadded];
  double input_weight[kNuPadded];
  ReflexContext reflex;
};

}  // namespace sanso::mpc
