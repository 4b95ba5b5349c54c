// Targets go through the same limits as on the robot: near the joint, and no faster than it may.
#include "host/motion/make/model_stage.h"

#include <algorithm>

#include "shared/model/op3_step.h"
#include "shared/policy/layer_sum.h"

namespace sanso::motion {

ModelStage::ModelStage(std::span<const model::State> reference, const mpc::CostWeights& weights,
                       const host::AugmentedModel& model, const StageSettings& settings)
    : reference_(reference),
      settings_(settings),
      model_(model),
      planner_(settings.planner, model_),
      x_(reference.front()),
      u_(model::joints(reference.front())) {
  mpc::TrialContext context;
  context.trial_id = 1;
  context.reference = reference_;
  context.weights = weights;
  planner_.begin_trial(context);
}

bool ModelStage::tell(int tick) {
  if (tick % settings_.ticks_per_plan == 0) {
    mpc::PlanRequest request;
    request.observed_tick = request.plan_tick = tick;
    request.x_observed = x_;
    request.sequence = static_cast<std::uint32_t>(tick) + 1;
    request.sigma = 0.0;
    planner_.plan(request, *plan_);
    if (plan_->status != Status::ok) return false;
  }
  policy::sample_upper(plan_->policy, tick, *knot_);
  upper_ = policy::affine(*knot_, x_);
  const model::Input wanted = model::joints(reference_[static_cast<std::size_t>(tick)]) + upper_;
  const double most = settings_.target_rate_rad_s * kTick_s;
  for (int j = 0; j < model::kNumJoints; ++j) {
    const double q = x_[model::kXJoint + j];
    const double near =
        std::clamp(wanted[j], q - settings_.target_offset_rad, q + settings_.target_offset_rad);
    u_[j] += std::clamp(near - u_[j], -most, most);
  }
  return true;
}

void ModelStage::move(const std::function<void(int step, const Loads& loads)>& look) {
  for (int i = 0; i < kStepsPerTick; ++i) {
    model::StepScratch scratch;
    model::State next;
    model::analytical_step(model_.analytical, model_.ground, x_.data(), u_.data(), kStep_s, 1,
                           next.data(), scratch);
    x_ = next;
    Loads loads{};
    for (std::size_t f = 0; f < 2; ++f)
      for (int k = 0; k < model::kCornersPerFoot; ++k)
        loads[f] += scratch.lambda[f][k][2] / kStep_s;
    look(i, loads);
  }
}

}  // namespace sanso::motion
