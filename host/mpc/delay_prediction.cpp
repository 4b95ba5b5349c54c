// Steps the model through the delay with the policy that is in force, tick by tick, as the
// controller will execute it.
#include "host/mpc/delay_prediction.h"

#include <algorithm>
#include <cmath>

#include "shared/model/op3_step.h"

namespace sanso::mpc {

model::State reference_at(const TrialContext& context, double tick) {
  const double last = static_cast<double>(context.reference.size()) - 1.0;
  const double position = std::clamp(tick, 0.0, last);
  const auto i = static_cast<std::size_t>(position);
  const double s = position - static_cast<double>(i);
  if (s == 0.0) return context.reference[i];
  return model::interpolate(context.reference[i], context.reference[i + 1], s);
}

namespace {

/// Where x gets to by itself in `time_s`.
model::State moved_on(const model::State& x, double time_s) {
  if (time_s == 0.0) return x;
  model::Tangent d = model::Tangent::Zero();
  d.head<model::kNv>() = time_s * x.segment<model::kNv>(model::kXVel);
  return model::plus(x, d);
}

}  // namespace

model::State DelayPrediction::step(const host::AugmentedModel& model,
                                   const ResidualWeights* residual, const model::State& x,
                                   const model::Input& u, double step_s) const {
  model::StepScratch scratch;
  model::State next;
  model::analytical_step(model.analytical, model.ground, x.data(), u.data(), step_s, 1, next.data(),
                         scratch);
  if (residual == nullptr) return next;
  // equal lanes: one evaluation costs the kernel no less
  alignas(64) double xs[kNx][kRollOutLanes], us[kNu][kRollOutLanes], nexts[kNx][kRollOutLanes];
  for (int i = 0; i < kNx; ++i)
    std::fill_n(xs[i], kRollOutLanes, x[i]), std::fill_n(nexts[i], kRollOutLanes, next[i]);
  for (int i = 0; i < kNu; ++i) std::fill_n(us[i], kRollOutLanes, u[i]);
  kernels_.add_residual(*residual, step_s / model.residual_dt_s, xs, us, nexts);
  for (int i = 0; i < kNx; ++i) next[i] = nexts[i][0];
  return next;
}

model::State DelayPrediction::predict(const host::AugmentedModel& model,
                                      const ResidualWeights* residual, const TrialContext& context,
                                      const PlanRequest& request, bool in_one_step) {
  const std::int32_t ticks = request.plan_tick - request.observed_tick;
  const double tick_s = to_seconds(kTickPeriod);
  model::State x = request.x_observed;
  model::Input mean = model::Input::Zero();
  const double lag_s = model.analytical.target_lag_s;
  // before it began another one was in force, which is forgotten: as its first knot
  const double first = request.in_use != nullptr ? request.in_use->first_tick : 0.0;
  for (std::int32_t tick = request.observed_tick; tick < request.plan_tick; ++tick) {
    // when the targets were that act now
    const double asked = tick < first ? tick : std::max(first, tick - lag_s / tick_s);
    const model::State reference = reference_at(context, asked);
    const model::Input u =
        policy::layer_outputs(request.in_use, context.middle, model::joints(reference),
                              context.u_rest, asked, moved_on(x, -lag_s), context.on,
                              context.reflex, scratch_)
            .sum();
    mean += u / ticks;
    x = step(model, residual, x, u, tick_s);
  }
  if (!in_one_step || ticks <= 0) return x;
  return step(model, residual, request.x_observed, mean, ticks * tick_s);
}

}  // namespace sanso::mpc
