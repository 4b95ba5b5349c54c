// A delay of one period, predicted with the step that identification and network were fitted to.
#include <gtest/gtest.h>

#include "host/mpc/delay_prediction.h"
#include "host/mpc/residual_weights.h"
#include "shared/model/op3_step.h"
#include "tests/host/mpc/support/problems.h"

namespace sanso::mpc {
namespace {

using model::Input;
using model::State;

State stepped(const State& x, const Input& u, double h) {
  static const model::StepModel kModel = model::make_step_model(model::nominal_parameters());
  static const model::Ground kPlane = model::make_plane();
  model::StepScratch scratch;
  State next;
  model::analytical_step(kModel, kPlane, x.data(), u.data(), h, 1, next.data(), scratch);
  return next;
}

TEST(DelayPrediction, ADelayOfOnePeriodIsTheStepThatWasLearned) {
  const std::vector<State> reference = problems::reference_of("stand");
  std::mt19937 random(2);
  host::AugmentedModel model;
  model.residual = problems::random_network(5);
  ResidualWeights weights;
  fold(*model.residual, weights);
  TrialContext context;
  context.reference = reference;  // stands still: the targets are the same at every tick
  context.on.reflex = false;
  PlanRequest request;
  request.observed_tick = 60;
  request.plan_tick = 66;
  request.x_observed = model::plus(reference[60], problems::random_disturbance(random, 0.5));
  DelayPrediction delay;
  const State predicted = delay.predict(model, &weights, context, request, true);
  const Input u = model::joints(reference[60]);
  const State learned = model::plus(stepped(request.x_observed, u, 0.06),
                                    host::residual_tangent(*model.residual, request.x_observed, u));
  EXPECT_LT(model::minus(predicted, learned).norm(), 1e-5);
  const State in_ticks = delay.predict(model, &weights, context, request);
  EXPECT_GT(model::minus(in_ticks, learned).norm(), 1e-3) << "the premise: ticks differ";
}

}  // namespace
}  // namespace sanso::mpc
