// The learner's bookkeeping, with little work: what it keeps, stores and leaves out.
#include <gtest/gtest.h>

#include "tests/host/learn/model/learner_world.h"
#include "tests/support/temp_folder.h"

namespace sanso::learn {
namespace {

/// Little work everywhere: enough to run every line of the learner under the sanitizers.
ModelLearningSettings quick() {
  ModelLearningSettings s;
  s.identify.search.population = 8;
  s.identify.search.elites = 3;
  s.identify.search.generations = 2;
  s.identify.max_windows = 12;
  s.residual.max_epochs = 2;
  return s;
}

TEST(ModelLearner, ATrialThatFallsAtOnceHasNoLoss) {
  const ModelLearner learner({}, weights(), quick(), kSeed);
  Episode fallen = episode_of_world(1);
  fallen.ticks.resize(30);  // 0.3 s: no window of N steps
  EXPECT_FALSE(learner.losses(fallen).has_value()) << "zero would read as a perfect model";
  EXPECT_TRUE(learner.losses(episode_of_world(1)).has_value());
}

TEST(ModelLearner, StoredAndReadBackIsTheSameModel) {
  ModelLearner learner({}, weights(), quick(), kSeed);
  learner.learn(episodes(8));
  learner.set_residual_trust({.share = 0.5});
  const test::TempFolder folder;
  const auto path = folder.path() / "model.bin";
  learner.save(path);
  ModelLearner other({}, weights(), quick(), kSeed);
  other.load(path);
  other.set_residual_trust(learner.residual_trust());
  const Episode probe = episode_of_world(50);
  EXPECT_EQ(other.losses(probe)->augmented, learner.losses(probe)->augmented) << "bit for bit";
  EXPECT_EQ(other.sigma(), learner.sigma());
  EXPECT_EQ(other.rounds(), 1);
}

TEST(ModelLearner, MembersOfAnEnsembleAreStoredToo) {
  ModelLearningSettings settings = quick();
  settings.ensemble.members = 2;
  ModelLearner learner({}, weights(), settings, kSeed);
  EXPECT_TRUE(learner.current().spread.empty());
  learner.begin_refined(learner.usable_windows(episode_of_world(1)));
  const test::TempFolder folder;
  learner.save(folder.path() / "model.bin");
  ModelLearner other({}, weights(), settings, kSeed);
  other.load(folder.path() / "model.bin");
  const auto members = learner.current().spread, back = other.current().spread;
  ASSERT_EQ(members.size(), 2U);
  ASSERT_EQ(back.size(), 2U);
  const std::vector<PredictionWindow> probe = learner.usable_windows(episode_of_world(50));
  const auto loss = [&](const model::StepModel& m) {
    return n_step_loss(probe, m, model::make_plane(), weights());
  };
  for (std::size_t e = 0; e < members.size(); ++e)
    EXPECT_EQ(loss(members[e]), loss(back[e])) << "bit for bit";
  EXPECT_NE(loss(members[0]), loss(members[1]));
}

TEST(ModelLearner, OneEpisodeTeachesNothing) {
  ModelLearner learner({}, weights(), {}, kSeed);
  const LearningRound round = learner.learn(episodes(1));
  EXPECT_EQ(round.episodes, 0);
  EXPECT_EQ(learner.rounds(), 0);
  EXPECT_EQ(learner.sigma(), kSigmaStart);
}

TEST(ModelLearner, StretchesOfAFallAreLeftOut) {
  Episode falling = episode_of_world(1);
  for (std::size_t i = 150; i < falling.ticks.size(); ++i) {
    falling.ticks[i].x.segment<4>(model::kXQuat) = math::quat_exp({0.0, 0.8, 0.0});
  }
  const ModelLearner learner({}, weights(), {}, kSeed);
  for (const PredictionWindow& w : learner.usable_windows(falling)) {
    for (const model::State& x : w.x) EXPECT_NEAR(x[model::kXQuat], 1.0, 0.1);
  }
  EXPECT_LT(learner.usable_windows(falling).size(),
            learner.usable_windows(episode_of_world(1)).size());
}

}  // namespace
}  // namespace sanso::learn
