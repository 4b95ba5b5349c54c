// Laws of the goals: they move towards the body by the rate, bounded, and not at all when
// switched off.
#include <gtest/gtest.h>

#include "host/learn/layers/goal_adaptation.h"

namespace sanso::learn {
namespace {

struct GoalAdaptation : testing::Test {
  GoalAdaptationSettings settings;
  policy::PrimitiveSet original, set;
  std::vector<model::State> reference{100, model::neutral_state()};
  Episode episode;

  /// An episode of `n` ticks in which the robot is `d` away from the reference all the time.
  void deviate_by(const model::Tangent& d, int n) {
    episode.ticks.assign(static_cast<std::size_t>(n), {});
    for (int i = 0; i < n; ++i) {
      episode.ticks[static_cast<std::size_t>(i)].trial_tick = i;
      episode.ticks[static_cast<std::size_t>(i)].x =
          model::plus(reference[static_cast<std::size_t>(i)], d);
    }
  }
};

TEST_F(GoalAdaptation, MovesTowardsTheBodyByTheRate) {
  model::Tangent d = model::Tangent::Zero();
  d[model::kDPos] = 0.1;
  d[model::kDJoint + 4] = -0.2;
  d[model::kDTheta + 1] = 0.3;
  deviate_by(d, 60);
  adapt_goals(episode, reference, original, settings, set);
  EXPECT_NEAR(set.scalar[0].goal, 0.03 * 0.1, 1e-12);
  EXPECT_NEAR(set.scalar[3 + 4].goal, -0.03 * 0.2, 1e-12);
  EXPECT_NEAR(math::quat_log(set.orientation.goal)[1], 0.03 * 0.3, 1e-12);
}

TEST_F(GoalAdaptation, LooksAtTheLastMomentsOnly) {
  model::Tangent d = model::Tangent::Zero();
  d[model::kDPos] = 0.1;
  deviate_by(d, 60);
  // before the window
  for (int i = 0; i < 30; ++i) episode.ticks[static_cast<std::size_t>(i)].x[model::kXPos] = 5.0;
  adapt_goals(episode, reference, original, settings, set);
  EXPECT_NEAR(set.scalar[0].goal, 0.003, 1e-12);
}

TEST_F(GoalAdaptation, TheWholeChangeIsBounded) {
  model::Tangent d = model::Tangent::Constant(2.0);
  d[model::kDPos + 2] = -2.0;
  deviate_by(d, 60);
  for (int failure = 0; failure < 50; ++failure)
    adapt_goals(episode, reference, original, settings, set);
  EXPECT_DOUBLE_EQ(set.scalar[0].goal, settings.max_position_m);
  EXPECT_DOUBLE_EQ(set.scalar[2].goal, -settings.max_lowering_m);
  EXPECT_DOUBLE_EQ(set.scalar[3].goal, settings.max_angle_rad);
  EXPECT_NEAR(math::quat_log(set.orientation.goal).norm(), settings.max_angle_rad, 1e-9);
}

TEST_F(GoalAdaptation, SwitchedOffItChangesNothing) {
  settings.enabled = false;
  deviate_by(model::Tangent::Constant(0.1), 60);
  adapt_goals(episode, reference, original, settings, set);
  EXPECT_EQ(set.scalar[0].goal, original.scalar[0].goal);
}

}  // namespace
}  // namespace sanso::learn
