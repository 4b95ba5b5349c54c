// The upper layer as the session uses it: plans along a motion, prediction through the delay,
// deadline, limits, no allocation.
#include "host/mpc/upper_layer.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "host/mpc/delay_prediction.h"
#include "shared/model/op3_step.h"
#include "tests/host/mpc/support/problems.h"

namespace {
std::atomic<long> allocations{0};
}
void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto a = static_cast<std::size_t>(alignment);
  if (void* p = std::aligned_alloc(a, (size + a - 1) / a * a)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

namespace sanso::mpc {
namespace {

struct Squat {
  std::vector<model::State> reference = problems::reference_of("squat");
  std::mt19937 random{5};
  TrialContext context() const {
    TrialContext c;
    c.trial_id = 3;
    c.reference = reference;
    return c;
  }
  PlanRequest request(int tick, double disturbance = 1.0) {
    PlanRequest r;
    r.observed_tick = tick;
    r.plan_tick = tick + 6;
    r.x_observed = model::plus(reference[static_cast<std::size_t>(tick)],
                               problems::random_disturbance(random, disturbance));
    r.sequence = static_cast<std::uint32_t>(tick);
    return r;
  }
};

TEST(UpperLayer, PlansLowerTheCostAllAlongAMotionAndAllocateNothing) {
  Squat squat;
  host::AugmentedModel model;
  model.residual = problems::random_network(1);
  UpperLayer upper({}, model);
  upper.begin_trial(squat.context());
  auto result = std::make_unique<PlanResult>();
  auto last = std::make_unique<policy::UpperPolicy>();
  for (int tick = 0; tick + 60 < static_cast<int>(squat.reference.size()); tick += 48) {
    PlanRequest request = squat.request(tick);
    request.in_use = last.get();
    const long before = allocations;
    upper.plan(request, *result);
    EXPECT_EQ(allocations - before, 0) << "tick " << tick;
    ASSERT_EQ(result->status, Status::ok);
    EXPECT_LT(result->cost_after, result->cost_before) << "tick " << tick;
    ASSERT_EQ(result->policy.knots.size(), policy::kMaxUpperKnots);
    EXPECT_EQ(result->policy.first_tick, tick + 6);
    EXPECT_EQ(result->policy.ticks_per_knot, 6);
    EXPECT_EQ(result->policy.trial_id, 3u);
    EXPECT_EQ(result->policy.knots[0].x, result->x_plan)
        << "the plan starts where it was predicted";
    for (const policy::Knot& knot : result->policy.knots) {
      EXPECT_LE(knot.K.norm(), 13.0 * (1 + 1e-12));
      EXPECT_LE(knot.u.cwiseAbs().maxCoeff(), 0.5);
    }
    *last = result->policy;
  }
}

/// Settings whose noise has slopes, and a model with another beside it.
struct Sloped {
  MpcSettings settings;
  host::AugmentedModel model;
  Sloped() {
    settings.noise_slope = true;
    settings.spread = 1.0;
    model::ModelParameters heavier = model::nominal_parameters();
    for (auto& body : heavier.body) body.mass *= 1.1;
    model.spread.push_back(model::make_step_model(heavier));
  }
};

void expect_same_bits_with_threads(MpcSettings settings, const host::AugmentedModel& model) {
  Squat squat;
  const PlanRequest request = squat.request(120);
  std::vector<PlanResult> results(3);
  const int threads[] = {1, 2, 4};
  for (std::size_t i = 0; i < 3; ++i) {
    settings.threads = threads[i];
    UpperLayer upper(settings, model);
    upper.begin_trial(squat.context());
    upper.plan(request, results[i]);
    EXPECT_EQ(results[i].cost_after, results[0].cost_after);
    EXPECT_EQ((results[i].policy.knots[0].K - results[0].policy.knots[0].K).norm(), 0.0);
    upper.plan(request, results[i]);  // and cold starts have no memory
    EXPECT_EQ(results[i].cost_after, results[0].cost_after);
  }
}

TEST(UpperLayer, TheSameRequestGivesTheSameBitsWithAnyNumberOfThreads) {
  expect_same_bits_with_threads({}, {});
  const Sloped sloped;
  expect_same_bits_with_threads(sloped.settings, sloped.model);
}

TEST(UpperLayer, NoiseWithSlopesIsPlannedWithoutAllocation) {
  Squat squat;
  const Sloped sloped;
  UpperLayer upper(sloped.settings, {});
  upper.set_model(sloped.model);
  upper.begin_trial(squat.context());
  const PlanRequest request = squat.request(120);
  const auto result = std::make_unique<PlanResult>(), without = std::make_unique<PlanResult>();
  const long before = allocations;
  upper.plan(request, *result);
  EXPECT_EQ(allocations - before, 0);
  ASSERT_EQ(result->status, Status::ok);
  EXPECT_LT(result->cost_after, result->cost_before);
  upper.set_model({});
  upper.plan(request, *without);
  EXPECT_GT(result->expected_cost - result->cost_after,
            without->expected_cost - without->cost_after)
      << "what the models differ by is priced beside the noise of the inputs";
}

TEST(UpperLayer, PredictionThroughTheDelayIsTheControllersSumTickByTick) {
  Squat squat;
  PlanRequest request = squat.request(200);
  auto in_use = std::make_unique<policy::UpperPolicy>();
  in_use->first_tick = 200;
  in_use->knots.try_resize(3);
  for (std::size_t k = 0; k < 3; ++k) {
    in_use->knots[k].x = squat.reference[200 + 6 * k];
    in_use->knots[k].u.setConstant(0.01 * static_cast<double>(k + 1));
    in_use->knots[k].K.setConstant(0.02);
  }
  request.in_use = in_use.get();
  const TrialContext context = squat.context();
  const host::AugmentedModel model;
  DelayPrediction prediction;
  const model::State predicted = prediction.predict(model, nullptr, context, request);
  // by hand, from the paper's equation
  model::State x = request.x_observed;
  model::StepScratch scratch;
  for (int tick = 200; tick < 206; ++tick) {
    const double s = (tick - 200) / 6.0;
    const model::State x_ref = model::interpolate(squat.reference[200], squat.reference[206], s);
    const model::Tangent dx = model::minus(x, x_ref);
    model::Input u = model::joints(squat.reference[static_cast<std::size_t>(tick)]);
    u.array() += 0.01 * (1 + s) + 0.02 * dx.sum();
    u += policy::reflex(x);
    model::State next;
    model::analytical_step(model.analytical, model.ground, x.data(), u.data(), 0.01, 1, next.data(),
                           scratch);
    x = next;
  }
  EXPECT_LT(model::minus(predicted, x).norm(), 1e-9);
}

TEST(UpperLayer, AShortTimeBudgetStillGivesAPolicy) {
  Squat squat;
  UpperLayer upper({}, host::AugmentedModel{});
  upper.begin_trial(squat.context());
  PlanRequest request = squat.request(100);
  request.time_budget = 1;  // one nanosecond: over before it began
  PlanResult result;
  upper.plan(request, result);
  EXPECT_EQ(result.status, Status::ok);
  EXPECT_EQ(result.stop, StopReason::deadline);
  EXPECT_EQ(result.iterations, 0);
  EXPECT_EQ(result.policy.knots[0].u.norm(), 0.0);  // what the other layers do anyway
}

TEST(UpperLayer, WarmStartBeginsWithTheLastPlanMovedOn) {
  Squat squat;
  MpcSettings settings;
  settings.warm_start = true;
  UpperLayer warm(settings, host::AugmentedModel{});
  UpperLayer cold({}, host::AugmentedModel{});
  warm.begin_trial(squat.context());
  cold.begin_trial(squat.context());
  PlanRequest request = squat.request(100);
  PlanResult a, b;
  warm.plan(request, a);
  cold.plan(request, b);
  EXPECT_EQ(a.cost_before, b.cost_before);  // the first plan of a trial has nothing to start from
  // the robot arrives where it was predicted; the next plan continues the last one
  request.observed_tick = request.plan_tick;
  request.plan_tick += 6;
  request.x_observed = a.x_plan;
  request.in_use = &a.policy;
  PlanResult c, d;
  warm.plan(request, c);
  cold.plan(request, d);
  EXPECT_LT(c.cost_before, 0.5 * d.cost_before);
  // pushed to where the last plan leads nowhere: as much of it as helps, none if none does
  for (const double push : {-1.5, -0.8, 0.8, 1.5}) {
    request.observed_tick = request.plan_tick;
    request.plan_tick += 6;
    request.x_observed[model::kXVel] = push;
    warm.plan(request, c);
    cold.plan(request, d);
    // a feedback of zero is added there, which may round the sums another way
    EXPECT_LE(c.cost_before, d.cost_before * (1 + 1e-9)) << push << " m/s";
  }
}

TEST(UpperLayer, APlanHangsOnNoEarlierOne) {
  Squat squat;
  host::AugmentedModel model;
  model.residual = problems::random_network(3);
  UpperLayer used({}, model), fresh({}, model);
  used.begin_trial(squat.context());
  fresh.begin_trial(squat.context());
  PlanResult before, after, alone;
  used.plan(squat.request(100), before);
  const PlanRequest second = squat.request(106);
  used.plan(second, after);
  fresh.plan(second, alone);
  ASSERT_EQ(after.policy.knots.size(), alone.policy.knots.size());
  for (std::size_t k = 0; k < alone.policy.knots.size(); ++k) {
    EXPECT_EQ(after.policy.knots[k].u, alone.policy.knots[k].u) << "knot " << k;
    EXPECT_EQ(after.policy.knots[k].K, alone.policy.knots[k].K) << "knot " << k;
  }
}

TEST(UpperLayer, RefusesAStateThatIsNotANumber) {
  Squat squat;
  UpperLayer upper({}, host::AugmentedModel{});
  PlanResult result;
  PlanRequest request = squat.request(0);
  upper.plan(request, result);
  EXPECT_EQ(result.status, Status::not_ready);  // no trial yet
  upper.begin_trial(squat.context());
  request.x_observed[20] = std::nan("");
  upper.plan(request, result);
  EXPECT_EQ(result.status, Status::out_of_range);
  EXPECT_TRUE(result.policy.knots.empty());
}

}  // namespace
}  // namespace sanso::mpc
