// Whole trials in process: firmware, emulated robot and planner over real bytes.
#include "tests/loop/support/loop_fixture.h"

namespace sanso::loop {
namespace {

TEST(Trial, StandSucceeds) {
  Loop loop("stand");
  const learn::Episode episode = loop.run(1);
  EXPECT_EQ(episode.end, learn::TrialEnd::completed)
      << learn::to_string(episode.end) << ", cost " << episode.cost;
  EXPECT_LT(episode.cost, 350.0);
  EXPECT_TRUE(loop.on_its_feet());
  // three witnesses: what the controller believes, what physics says, what the reference asked
  const model::State& believed = episode.ticks.back().x;
  const model::State& real = episode.truth.back().x;
  EXPECT_NEAR(believed[model::kXPos + 2], real[model::kXPos + 2], 0.01);
  EXPECT_NEAR(real[model::kXPos + 2], episode.reference.back()[model::kXPos + 2], 0.02);
}

TEST(Trial, SquatSucceedsAndEveryPolicyArrivesInTime) {
  Loop loop("squat");
  const learn::Episode episode = loop.run(1);
  EXPECT_EQ(episode.end, learn::TrialEnd::completed)
      << learn::to_string(episode.end) << ", cost " << episode.cost;
  EXPECT_LT(episode.cost, 350.0);
  EXPECT_GE(episode.plans.size(), episode.ticks.size() / kTicksPerUpper - 2);
  for (const learn::PlanRecord& plan : episode.plans) {
    EXPECT_EQ(plan.late, 0) << "policy for tick " << plan.policy.first_tick;
    EXPECT_EQ(plan.policy.first_tick - plan.observed_tick, kTicksPerUpper);
    EXPECT_LE(plan.cost_after, plan.cost_before);
  }
  EXPECT_EQ(episode.ticks.back().bus_lost + episode.ticks.back().bus_corrupt, 0u);
}

TEST(Trial, OneSeedGivesTheSameBits) {
  Loop first("stand"), second("stand");
  first.setup.duration_ticks = second.setup.duration_ticks = 120;
  const std::uint64_t a = learn::digest(first.run(5)), b = learn::digest(second.run(5)),
                      c = learn::digest(second.run(6));
  EXPECT_EQ(a, b);
  EXPECT_NE(a, c) << "another seed has to give another trial";
}

TEST(Trial, TheCostOfTheTruthIsThatOfTheEstimatesWhereTheyAgree) {
  Loop loop("stand");
  learn::Episode episode = loop.run(1);
  const double believed = episode.cost, real = learn::cost_of_truth(episode, loop.motion.weights);
  EXPECT_NEAR(real, believed, 0.5 * believed) << "the estimator is good, not perfect";
  EXPECT_NE(real, believed);
  for (std::size_t i = 0; i < episode.ticks.size(); ++i) episode.truth[i].x = episode.ticks[i].x;
  EXPECT_NEAR(learn::cost_of_truth(episode, loop.motion.weights), believed, 1e-3 * believed);
  episode.truth.clear();
  EXPECT_LT(learn::cost_of_truth(episode, loop.motion.weights), 0.0);
}

TEST(Trial, APushMovesTheTorsoFromItsTickOnAndNotBefore) {
  constexpr int kPushTick = 60;
  Loop calm("stand"), pushed("stand");
  calm.setup.duration_ticks = pushed.setup.duration_ticks = 90;
  const learn::Episode undisturbed = calm.run(5);
  pushed.stand(5);
  pushed.robot().push_at({kPushTick, 0.1, {0.0, 8.0, 0.0}, {}});  // 0.8 N s to the left
  learn::Episode episode =
      learn::run_trial(*pushed.link, pushed.upper, pushed.setup, pushed.settings);
  pushed.access.add_measurements(episode);

  double before = 0.0, after = 0.0;
  for (std::size_t i = 0; i < std::min(episode.ticks.size(), undisturbed.ticks.size()); ++i) {
    const double moved =
        episode.truth[i].x[model::kXVel + 1] - undisturbed.truth[i].x[model::kXVel + 1];
    double& largest = episode.ticks[i].trial_tick <= kPushTick ? before : after;
    largest = std::max(largest, moved);
  }
  EXPECT_EQ(before, 0.0);
  EXPECT_GT(after, 0.02);  // m/s; the whole robot flying free would get 0.8 N s / 3.5 kg = 0.23
  EXPECT_LT(after, 0.6);
}

}  // namespace
}  // namespace sanso::loop
