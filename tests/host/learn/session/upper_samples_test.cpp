// What the middle layer is shown of the upper layer's work: also the knots that pass before the
// first plan arrives.
#include <gtest/gtest.h>

#include "host/learn/session/session.h"

namespace sanso::learn {
namespace {

constexpr int kFirstPlanTick = 6;  // the first plan arrives 60 ms into the trial

policy::Knot knot_of(double u) {
  policy::Knot knot;
  knot.u.setConstant(u);
  knot.K.setConstant(0.1 * u);
  return knot;
}

/// `ticks` observations; from `first_plan` on they execute one plan of two knots, 60 ms apart.
Episode episode_with_plan_from(int first_plan, int ticks) {
  Episode episode;
  PlanRecord plan;
  plan.policy.sequence = 7;
  plan.policy.first_tick = first_plan;
  plan.policy.ticks_per_knot = 6;
  plan.policy.knots.try_push(knot_of(1.0));
  plan.policy.knots.try_push(knot_of(2.0));
  episode.plans.push_back(plan);
  for (int t = 0; t < ticks; ++t) {
    wire::Observation o{};
    o.trial_tick = t;
    o.upper_sequence = t >= first_plan ? 7 : 0;
    o.upper_weight = t >= first_plan ? 1.0f : 0.0f;
    episode.ticks.push_back(o);
  }
  return episode;
}

TEST(UpperSamples, KnotsBeforeTheFirstPlanSeeItsFirstKnot) {
  const std::vector<UpperSample> samples =
      upper_samples(episode_with_plan_from(kFirstPlanTick, 13));
  ASSERT_EQ(samples.size(), 5u);
  for (const std::size_t before : {std::size_t{0}, std::size_t{1}, std::size_t{2}}) {
    EXPECT_EQ(samples[before].weight, 1.0) << before;
    EXPECT_DOUBLE_EQ(samples[before].knot.u[0], 1.0) << before;
    EXPECT_DOUBLE_EQ(samples[before].knot.K(0, 0), 0.1) << before;
  }
  EXPECT_DOUBLE_EQ(samples[3].knot.u[0], 1.5) << "half way between the plan's knots";
  EXPECT_DOUBLE_EQ(samples[4].knot.u[0], 2.0);
}

TEST(UpperSamples, AGapAfterTheFirstPlanTeachesNothing) {
  Episode episode = episode_with_plan_from(kFirstPlanTick, 13);
  episode.ticks[9].upper_sequence = 0;  // the plan was lost for knot 3
  const std::vector<UpperSample> samples = upper_samples(episode);
  EXPECT_EQ(samples[3].weight, 0.0);
}

TEST(UpperSamples, WithoutAnyPlanNothingIsLearned) {
  for (const UpperSample& s : upper_samples(episode_with_plan_from(100, 13)))
    EXPECT_EQ(s.weight, 0.0);
}

}  // namespace
}  // namespace sanso::learn
