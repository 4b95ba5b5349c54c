#include "host/learn/model_learner.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "shared/model/op3_step.h"

namespace sanso::learn {
namespace {

constexpr std::uint64_t kSeed = 5;
constexpr int kTicks = 300;

// A robot that is the model with softer servos, sampled every 10 ms (its own steps are 10 ms, the learner's 60 ms).
// `knee_offset_rad`: its knees stand off from what the controller believes, which no parameter of the model can say.
Episode episode_of_world(std::uint32_t trial, double stiffness = 0.7, double knee_offset_rad = 0.0) {
  model::ModelParameters truth = model::nominal_parameters();
  for (auto& servo : truth.servo) servo.stiffness *= stiffness;
  const model::StepModel world = model::make_step_model(truth);
  model::Input pose;
  pose << 0, 0, 0.56, -1.13, -0.57, 0, 0, 0, -0.56, 1.13, 0.57, 0;
  model::State x = model::neutral_state();
  x[2] = 0.245;
  x.segment<model::kNumJoints>(model::kXJoint) = pose;
  std::mt19937_64 rng(kSeed + trial);
  std::normal_distribution<double> normal;
  model::StepScratch scratch;
  Episode episode;
  episode.trial = trial;
  model::Input u = pose;
  for (int tick = 0; tick < kTicks; ++tick) {
    if (tick % 12 == 0) {
      for (int j = 0; j < model::kNumJoints; ++j) u[j] = pose[j] + 0.05 * normal(rng);
    }
    wire::Observation o;
    o.trial_tick = tick;
    o.x = x;
    o.u_out = u;
    episode.ticks.push_back(o);
    model::Input applied = u;
    applied[3] += knee_offset_rad;
    applied[9] -= knee_offset_rad;
    model::analytical_step(world, model::make_plane(), x.data(), applied.data(), 0.01, 1, x.data(), scratch);
  }
  return episode;
}

model::Tangent weights() {
  model::Tangent w = model::Tangent::Constant(3.0);
  w.segment<3>(0) << 300, 300, 1000;
  w.segment<3>(3) << 60, 60, 20;
  w.segment<12>(24).setConstant(0.02);
  return w;
}

std::vector<Episode> episodes(std::uint32_t count, double knee_offset_rad = 0.0) {
  std::vector<Episode> out;
  for (std::uint32_t t = 0; t < count; ++t) out.push_back(episode_of_world(t, 0.7, knee_offset_rad));
  return out;
}

TEST(SigmaLaw, FallsFromStartToFloorWithTheLoss) {
  EXPECT_NEAR(sigma_of_loss(0.0), kSigmaFloor, 1e-12);
  EXPECT_NEAR(sigma_of_loss(1e9), kSigmaStart, 1e-6);
  for (double loss = 0.01; loss < 100; loss *= 2) EXPECT_LT(sigma_of_loss(loss), sigma_of_loss(2 * loss));
  EXPECT_EQ(sigma_of_loss(std::numeric_limits<double>::infinity()), kSigmaStart);
}

TEST(ModelLearner, LowersTheLossOfAnUnseenTrial) {
  ModelLearner learner({}, weights(), {}, kSeed);
  const LearningRound round = learner.learn(episodes(8));
  EXPECT_TRUE(round.identification_used);
  const ModelLosses unseen = learner.losses(episode_of_world(99));
  EXPECT_LT(unseen.augmented, 0.5 * unseen.initial);
  EXPECT_LT(learner.sigma(), kSigmaStart);
}

TEST(ModelLearner, ANewNetworkIsUsedOnlyAfterATrialHasShownThatItHelps) {
  constexpr double kOffset = 0.05;
  ModelLearner learner({}, weights(), {}, kSeed);
  ASSERT_TRUE(learner.learn(episodes(8, kOffset)).residual_kept);
  EXPECT_FALSE(learner.current().residual.has_value());
  EXPECT_TRUE(learner.judge_residual(episode_of_world(11, 0.7, kOffset)));  // 11 and 12 stay on their feet
  EXPECT_EQ(learner.residual_trust().share, kShareStep);
  const ModelLosses next = learner.losses(episode_of_world(12, 0.7, kOffset));
  EXPECT_LT(next.augmented, next.analytical);
}

TEST(ModelLearner, ANetworkThatNoLongerHoldsIsPutAside) {
  ModelLearner learner({}, weights(), {}, kSeed);
  ASSERT_TRUE(learner.learn(episodes(8)).residual_kept);
  learner.set_residual_trust({.share = 1.0});
  const Episode moved_on = episode_of_world(10, 1.3);  // another robot stands for data that the network has not seen
  const ModelLosses with = learner.losses(moved_on);
  ASSERT_GT(with.augmented, with.analytical) << "the premise: here the network is worse than none";
  learner.judge_residual(moved_on);
  const ModelLosses next = learner.losses(moved_on);
  EXPECT_LE(next.augmented, next.analytical);
}

TEST(ModelLearner, StoredAndReadBackIsTheSameModel) {
  ModelLearner learner({}, weights(), {}, kSeed);
  learner.learn(episodes(8));
  learner.set_residual_trust({.share = 0.5});
  const auto path = std::filesystem::temp_directory_path() / "sanso_model_learner_test.bin";
  learner.save(path);
  ModelLearner other({}, weights(), {}, kSeed);
  other.load(path);
  other.set_residual_trust(learner.residual_trust());
  std::filesystem::remove(path);
  const Episode probe = episode_of_world(50);
  EXPECT_EQ(other.losses(probe).augmented, learner.losses(probe).augmented) << "bit for bit";
  EXPECT_EQ(other.sigma(), learner.sigma());
  EXPECT_EQ(other.rounds(), 1);
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
  EXPECT_LT(learner.usable_windows(falling).size(), learner.usable_windows(episode_of_world(1)).size());
}

}  // namespace
}  // namespace sanso::learn
