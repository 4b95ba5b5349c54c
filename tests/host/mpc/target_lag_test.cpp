// A robot on which targets act 30 ms after they were sent: a planner that knows it does better.
#include <gtest/gtest.h>

#include <deque>

#include "host/mpc/cost.h"
#include "host/mpc/upper_layer.h"
#include "shared/model/op3_step.h"
#include "tests/host/mpc/support/problems.h"

namespace sanso::mpc {
namespace {

constexpr int kLagTicks = 3;

struct Run {
  std::vector<model::State> reference;
  double lag_s;  // that the planner's model has
};

/// Costs of `ticks` of the motion; the model itself is the robot, but for what is late. A plan
/// every 60 ms, from the state 60 ms before it begins.
double cost_of(const Run& run, int ticks) {
  model::ModelParameters theta = model::nominal_parameters();
  const model::StepModel robot = model::make_step_model(theta);
  theta.target_lag_s = run.lag_s;
  host::AugmentedModel planned;
  planned.analytical = model::make_step_model(theta);
  UpperLayer upper({}, planned);
  TrialContext context;
  context.reference = run.reference;
  upper.begin_trial(context);

  auto result = std::make_unique<PlanResult>();
  auto in_use = std::make_unique<policy::UpperPolicy>(),
       next = std::make_unique<policy::UpperPolicy>();
  model::State x = run.reference.front();
  std::deque<model::Input> sent(kLagTicks, model::Input(model::joints(x)));
  model::StepScratch scratch;
  policy::Knot knot;
  double cost = 0.0;
  for (int tick = 0; tick < ticks; ++tick) {
    const model::State& reference = run.reference[static_cast<std::size_t>(tick)];
    if (tick % 6 == 0) {
      *in_use = *next;
      PlanRequest request;
      request.observed_tick = tick;
      request.plan_tick = tick + 6;
      request.x_observed = x;
      request.in_use = in_use.get();
      upper.plan(request, *result);
      EXPECT_EQ(result->status, Status::ok);
      *next = result->policy;
      cost += state_cost(context.weights, x, reference);
    }
    sent.push_back(policy::layer_outputs(in_use.get(), nullptr, model::joints(reference),
                                         context.u_rest, tick, x, context.on, context.reflex, knot)
                       .sum());
    model::State after;
    model::analytical_step(robot, planned.ground, x.data(), sent.front().data(), 0.01, 1,
                           after.data(), scratch);
    sent.pop_front();
    x = after;
  }
  return cost;
}

TEST(TargetLag, APlannerThatKnowsItFollowsAWalkBetter) {
  const std::vector<model::State> walk = problems::reference_of("walk_forward");
  const double knows = cost_of({walk, kLagTicks * to_seconds(kTickPeriod)}, 360),
               does_not = cost_of({walk, 0.0}, 360);
  EXPECT_LT(knows, 0.8 * does_not) << knows << " and " << does_not;
}

/// Standing, where the other layers ask the same at all times, so that both plans are one.
policy::UpperPolicy plan_standing(double lag_s, const std::vector<model::State>& reference,
                                  double dt_s = 0.06) {
  TrialContext context;
  context.reference = reference;
  context.on.reflex = false;  // alone it would see another state
  host::AugmentedModel model;
  model.analytical.target_lag_s = lag_s;
  MpcSettings settings;
  settings.dt_s = dt_s;
  UpperLayer upper(settings, model);
  upper.begin_trial(context);
  PlanRequest request;
  request.plan_tick = 6;
  request.x_observed = reference.front();
  request.x_observed[model::kXOmega + 1] = 0.3;  // pushed
  PlanResult result;
  upper.plan(request, result);
  EXPECT_EQ(result.status, Status::ok);
  return result.policy;
}

TEST(TargetLag, WhatActsLaterIsAskedForEarlier) {
  const std::vector<model::State> held(200, problems::reference_of("stand").front());
  const policy::UpperPolicy now = plan_standing(0.0, held), late = plan_standing(0.02, held);
  ASSERT_EQ(now.knots.size(), late.knots.size());
  ASSERT_GT(now.knots[1].u.norm(), 1e-3) << "the premise: there is something to ask for";
  for (std::size_t k = 0; k + 1 < now.knots.size(); ++k) {
    const model::Input third = now.knots[k].u + (now.knots[k + 1].u - now.knots[k].u) / 3.0;
    EXPECT_LT((late.knots[k].u - third).norm(), 1e-12) << "knot " << k;
    EXPECT_EQ(late.knots[k].x, now.knots[k].x) << "states are compared when they are there";
  }
}

TEST(TargetLag, MayBeLongerThanAStep) {
  const std::vector<model::State> held(200, problems::reference_of("stand").front());
  const policy::UpperPolicy now = plan_standing(0.0, held, 0.02),
                            late = plan_standing(0.03, held, 0.02);
  for (std::size_t k = 0; k + 2 < now.knots.size(); ++k) {
    const model::Input half = 0.5 * (now.knots[k + 1].u + now.knots[k + 2].u);
    EXPECT_LT((late.knots[k].u - half).norm(), 1e-12) << "knot " << k;
  }
}

}  // namespace
}  // namespace sanso::mpc
