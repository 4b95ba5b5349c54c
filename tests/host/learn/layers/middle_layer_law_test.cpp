// Laws of the middle layer: fixed point, kept sum, forgetting, limited gain.
#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "host/learn/layers/middle_layer.h"

namespace sanso::learn {
namespace {

using model::State;

constexpr int kKnots = 5;

State random_state(std::mt19937& rng) {
  std::normal_distribution<double> normal;
  model::Tangent d;
  for (int i = 0; i < model::kNdx; ++i) d[i] = 0.4 * normal(rng);
  return model::plus(model::neutral_state(), d);
}

struct MiddleLayer : testing::Test {
  std::mt19937 rng{20240301};
  MiddleLayerSettings settings;
  std::vector<State> reference;
  std::unique_ptr<policy::MiddleTable> table = std::make_unique<policy::MiddleTable>();
  std::vector<UpperSample> upper{kKnots};

  void SetUp() override {
    for (int i = 0; i < kKnots; ++i) reference.push_back(random_state(rng));
    for (UpperSample& s : upper) {
      s.knot = {model::Input::Random(), random_state(rng), 0.1 * model::Gain::Random()};
      s.weight = 1.0;
    }
    start_middle_layer(reference, settings, *table);
  }
};

TEST_F(MiddleLayer, StartsAtTheReferenceOrAtTheFirstState) {
  EXPECT_EQ(table->knots[3].x, reference[3]);
  settings.start_at_reference = false;
  start_middle_layer(reference, settings, *table);
  EXPECT_EQ(table->knots[3].x, reference[0]);
  EXPECT_EQ(table->knots[3].u.norm() + table->knots[3].K.norm(), 0.0);
}

TEST_F(MiddleLayer, FixedPointIsAlphaOverMuTimesTheUpperLayer) {
  for (int trial = 0; trial < 3000; ++trial)
    update_middle_layer(upper, reference, false, settings, *table);
  const double a = settings.learning_rate, mu = settings.forgetting_rate;
  for (int i = 0; i < kKnots; ++i) {
    EXPECT_NEAR((table->knots[i].u - a / mu * upper[i].knot.u).norm(), 0.0, 1e-9);
    EXPECT_NEAR((table->knots[i].K - 0.3 * a / mu * upper[i].knot.K).norm(), 0.0, 1e-9);
    // balance of the two pulls: alpha (x_up ⊖ x) = mu (x ⊖ x_init), in the tangent at x
    const model::Tangent pull = a * model::minus(upper[i].knot.x, table->knots[i].x) +
                                mu * model::minus(reference[i], table->knots[i].x);
    EXPECT_NEAR(pull.norm(), 0.0, 1e-9);
  }
}

TEST_F(MiddleLayer, SumOfBothLayersIsKeptWhenTheUpperLayerFollows) {
  // An upper layer that needs a fixed total input hands it over: u_up = total - u_mid  =>  u_mid ->
  // alpha/(alpha+mu) total.
  const model::Input total = model::Input::Constant(0.1);
  for (int trial = 0; trial < 400; ++trial) {
    for (int i = 0; i < kKnots; ++i) upper[i].knot.u = total - table->knots[i].u;
    update_middle_layer(upper, reference, false, settings, *table);
  }
  EXPECT_NEAR(table->knots[2].u[0], 0.1 * 0.05 / 0.06, 1e-6);
}

TEST_F(MiddleLayer, LearnsNothingFromAFailedTrialAndForgets) {
  update_middle_layer(upper, reference, false, settings, *table);
  const model::Input before = table->knots[1].u;
  update_middle_layer(upper, reference, true, settings, *table);
  EXPECT_NEAR((table->knots[1].u - 0.99 * before).norm(), 0.0, 1e-15);
}

TEST_F(MiddleLayer, AFadedPolicyTeachesByItsWeight) {
  upper[0].weight = 0.0;
  upper[1].weight = 0.5;
  update_middle_layer(upper, reference, false, settings, *table);
  EXPECT_EQ(table->knots[0].u.norm(), 0.0);
  EXPECT_NEAR((table->knots[1].u - 0.025 * upper[1].knot.u).norm(), 0.0, 1e-15);
  EXPECT_NEAR((table->knots[2].u - 0.05 * upper[2].knot.u).norm(), 0.0, 1e-15);
}

TEST_F(MiddleLayer, AGainSpikeIsLimitedBeforeItIsLearned) {
  upper[0].knot.K = 100.0 * model::Gain::Random();
  update_middle_layer(upper, reference, false, settings, *table);
  EXPECT_NEAR(table->knots[0].K.norm(), 0.3 * 0.05 * settings.max_gain_norm, 1e-12);
}

}  // namespace
}  // namespace sanso::learn
