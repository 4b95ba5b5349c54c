// The network learns what is there, refuses what noise taught, and gives the same bits for the
// same seed.
#include "host/learn/model/residual_training.h"

#include <gtest/gtest.h>

#include <random>

namespace sanso::learn {
namespace {

constexpr std::uint64_t kSeed = 7;

// A friction-like term on the joint rates and a quadratic one on the gravity direction: nothing a
// constant could learn.
model::Tangent missing_physics(const host::Features& f) {
  model::Tangent t = model::Tangent::Zero();
  for (int j = 0; j < model::kNumJoints; ++j)
    t[model::kDJointRate + j] = -0.1 * std::tanh(3.0 * f[22 + j]);
  t[model::kDVel] = 0.05 * f[1] * f[1];
  return t;
}

TransitionSet recorded(std::size_t trials, std::size_t per_trial, bool with_effect, double noise) {
  std::mt19937_64 rng(kSeed);
  std::normal_distribution<double> normal;
  TransitionSet data;
  for (std::size_t trial = 0; trial < trials; ++trial) {
    for (std::size_t i = 0; i < per_trial; ++i) {
      host::Features f;
      for (double& v : f) v = normal(rng);
      model::Tangent target = with_effect ? missing_physics(f) : model::Tangent::Zero();
      for (double& v : target) v += noise * normal(rng);
      data.add(static_cast<std::uint32_t>(trial), f, target);
    }
  }
  return data;
}

ResidualSettings quick() {
  ResidualSettings s;
  s.learning_rate = 1e-3;  // the paper's 1e-4 learns the same in ten times the epochs
  s.max_epochs = 60;
  return s;
}

TEST(ResidualTraining, ExplainsHeldOutTransitionsOfAnUnseenTrial) {
  const auto result =
      train_residual(recorded(5, 1500, true, 1e-3), model::Tangent::Ones(), quick(), kSeed);
  ASSERT_TRUE(result.network.has_value());
  EXPECT_LT(result.heldout_loss, 0.2 * result.heldout_loss_without)
      << "at least 80 % of the missing part explained";
}

TEST(ResidualTraining, GateRefusesWhatNoiseTaught) {
  // Pure noise: whatever the network learned is wrong on the held-out trial, so there is no
  // network.
  ResidualSettings s = quick();
  s.learning_rate = 1e-2;
  s.l2 = 0;
  const auto result =
      train_residual(recorded(3, 150, false, 1.0), model::Tangent::Ones(), s, kSeed);
  EXPECT_EQ(result.network.has_value(), result.heldout_loss < result.heldout_loss_without);
  EXPECT_NEAR(result.heldout_loss, result.heldout_loss_without, 0.1 * result.heldout_loss_without)
      << "early stop keeps the best network, which is close to none";
}

TEST(ResidualTraining, TheNewestTrialsDecide) {
  // Four trials show an effect, the newest shows its opposite: what the old ones taught does not
  // hold any more.
  TransitionSet data = recorded(5, 300, true, 1e-3);
  for (std::size_t row = 0; row < data.size(); ++row) {
    if (data.trial[row] != 4) continue;
    for (int i = 0; i < model::kNdx; ++i)
      data.targets[row * model::kNdx + static_cast<std::size_t>(i)] *= -1.0F;
  }
  const auto result = train_residual(data, model::Tangent::Ones(), quick(), kSeed);
  EXPECT_LT(result.epochs, quick().max_epochs) << "stopped early";
  EXPECT_GE(result.heldout_loss, 0.9 * result.heldout_loss_without)
      << "hardly any correction is left";
}

TEST(ResidualTraining, HoldsOutAtLeastOneTrialAndNeverAll) {
  EXPECT_EQ(newest_heldout(10, 0.2), 2U);
  EXPECT_EQ(newest_heldout(2, 0.05), 1U);
  EXPECT_EQ(newest_heldout(2, 0.5), 1U);
  EXPECT_EQ(newest_heldout(3, 0.9), 2U);
}

TEST(ResidualTraining, SameSeedSameBits) {
  const TransitionSet data = recorded(3, 200, true, 1e-2);
  ResidualSettings s = quick();
  s.max_epochs = 3;
  const auto a = train_residual(data, model::Tangent::Ones(), s, kSeed),
             b = train_residual(data, model::Tangent::Ones(), s, kSeed);
  ASSERT_TRUE(a.network && b.network);
  EXPECT_EQ(a.network->W1, b.network->W1);
  EXPECT_EQ(a.network->W3, b.network->W3);
}

TEST(ResidualTraining, ConstantCoordinatesDoNotBlowUp) {
  TransitionSet data = recorded(3, 200, true, 0.0);
  for (std::size_t i = 0; i < data.size(); ++i)
    data.features[i * host::kFeatures] = 0.25F;  // base height never changed
  const auto result = train_residual(data, model::Tangent::Ones(), quick(), kSeed);
  ASSERT_TRUE(result.network.has_value());
  host::Features f = host::Features::Zero();
  f[0] = 0.25;
  EXPECT_TRUE(host::residual_output(*result.network, f).allFinite());
}

TEST(ResidualTraining, SaysWhatIsMissing) {
  EXPECT_THROW(train_residual(recorded(1, 500, true, 0), model::Tangent::Ones(), quick(), kSeed),
               std::invalid_argument);
  EXPECT_THROW(train_residual(recorded(2, 10, true, 0), model::Tangent::Ones(), quick(), kSeed),
               std::invalid_argument);
}

}  // namespace
}  // namespace sanso::learn
