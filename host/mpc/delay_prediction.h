// From the observed state through the delay, with the sum that the controller really forms: one
// model step a tick, or one step over all of it with the mean of what the ticks apply, which is the
// step that was identified and that the residual network corrects.
#pragma once

#include "host/model/augmented_model.h"
#include "host/mpc/lane_kernels.h"
#include "host/mpc/plan_request.h"
#include "host/mpc/trial_context.h"

namespace sanso::mpc {

class DelayPrediction {
 public:
  DelayPrediction() : kernels_(lane_kernels()) {}

  /// x at request.plan_tick. `residual` may be null; its training step length is
  /// `model.residual_dt_s`. No allocation.
  model::State predict(const host::AugmentedModel& model, const ResidualWeights* residual,
                       const TrialContext& context, const PlanRequest& request,
                       bool in_one_step = false);

 private:
  model::State step(const host::AugmentedModel& model, const ResidualWeights* residual,
                    const model::State& x, const model::Input& u, double step_s) const;

  const LaneKernels& kernels_;
  policy::Knot scratch_;
};

/// Reference at a trial tick (fractional between ticks), held at both ends. Needs a reference.
model::State reference_at(const TrialContext& context, double tick);

}  // namespace sanso::mpc
