// A trial's layers in time: which policy is used when, fading, refusals.
#include "firmware/app/trial.h"

#include <gtest/gtest.h>

#include <memory>

#include "tests/firmware/support/emulated_controller.h"

namespace sanso::firmware {
namespace {

policy::UpperPolicy policy_of(std::uint32_t sequence, std::int32_t first_tick, double u,
                              std::uint32_t trial = 1) {
  policy::UpperPolicy p;
  p.sequence = sequence;
  p.trial_id = trial;
  p.first_tick = first_tick;
  policy::Knot knot;
  knot.u.setConstant(u);
  for (int i = 0; i < 3; ++i) p.knots.try_push(knot);
  return p;
}

class TrialTest : public ::testing::Test {
 protected:
  void SetUp() override {
    handover_->primitives.back() = testing::still_primitives(testing::standing_pose(), 3.0);
    handover_->primitives.publish();
    trial_.take_uploads(*handover_, false);
  }
  void start(std::uint8_t layers = policy::LayerSwitches{.reflex = false}.mask()) {
    trial_.start({1, wire::CommandKind::start_trial, 1, layers, 100});
  }
  void send(const policy::UpperPolicy& p) {
    handover_->upper.back() = p;
    handover_->upper.publish();
    trial_.take_uploads(*handover_, true);
  }
  /// The upper layer's part at the next tick.
  double upper() {
    trial_.advance();
    return trial_.layers(model::neutral_state()).upper[0];
  }
  std::unique_ptr<Handover> handover_ = std::make_unique<Handover>();
  Trial trial_{policy::ReflexSettings{}};
};

TEST_F(TrialTest, NoPolicyMeansNoUpperLayer) {
  start();
  EXPECT_EQ(upper(), 0.0);
  EXPECT_FALSE(trial_.has_upper());
}

TEST_F(TrialTest, APolicyBeginsAtItsFirstTickAndFadesOverOnePeriodAfterItsLastKnot) {
  start();
  send(policy_of(1, 2, 0.6));
  for (int k = 0; k <= 30; ++k) {
    const double expected =
        k < 2 ? 0.0 : (k <= 14 ? 0.6 : std::max(0.0, 0.6 * (1.0 - (k - 14) / 6.0)));
    EXPECT_NEAR(upper(), expected, 1e-12) << "tick " << k;
  }
}

TEST_F(TrialTest, ALaterPolicyTakesOverAtItsOwnFirstTick) {
  start();
  send(policy_of(1, 0, 0.1));
  EXPECT_DOUBLE_EQ(upper(), 0.1);
  send(policy_of(2, 3, 0.2));
  EXPECT_DOUBLE_EQ(upper(), 0.1);
  EXPECT_DOUBLE_EQ(upper(), 0.1);
  EXPECT_DOUBLE_EQ(upper(), 0.2);
}

TEST_F(TrialTest, OlderPoliciesAndThoseOfAnotherTrialAreDropped) {
  start();
  send(policy_of(5, 0, 0.1));
  EXPECT_DOUBLE_EQ(upper(), 0.1);
  send(policy_of(4, 0, 0.9));
  send(policy_of(6, 0, 0.9, 2));
  EXPECT_DOUBLE_EQ(upper(), 0.1);
  EXPECT_EQ(trial_.stale_policies(), 2u);
}

TEST_F(TrialTest, APolicySentBeforeTheStartIsUsed) {
  send(policy_of(1, 0, 0.3));
  start();
  EXPECT_DOUBLE_EQ(upper(), 0.3);
}

TEST_F(TrialTest, TheLowerLayerPlaysThePrimitives) {
  start();
  trial_.advance();
  EXPECT_TRUE(trial_.layers(model::neutral_state()).lower.isApprox(testing::standing_pose(), 1e-9));
}

TEST_F(TrialTest, ATableOfAnotherTrialIsRefused) {
  policy::MiddleTable& table = handover_->middle.back();
  table.trial_id = 9;
  table.knots.clear();
  table.knots.try_push({});
  handover_->middle.publish();
  trial_.take_uploads(*handover_, false);
  EXPECT_EQ(trial_.check({1, wire::CommandKind::start_trial, 1, policy::LayerSwitches::kAll, 0}),
            Refusal::stale_table);
  EXPECT_EQ(trial_.check({1, wire::CommandKind::start_trial, 9, policy::LayerSwitches::kAll, 0}),
            Refusal::none);
  EXPECT_EQ(trial_.check({1, wire::CommandKind::start_trial, 1, policy::LayerSwitches::kLower, 0}),
            Refusal::none);
}

TEST_F(TrialTest, EndsAfterItsDuration) {
  trial_.start({1, wire::CommandKind::start_trial, 1, policy::LayerSwitches::kAll, 3});
  for (int k = 0; k < 3; ++k) {
    trial_.advance();
    EXPECT_EQ(trial_.over(), k == 2) << "tick " << k;
  }
}

TEST(LayerSum, ReflexPushesAwayFromBothLimits) {
  model::State x = model::neutral_state();
  for (int j = 0; j < model::kNumJoints; ++j) {
    const model::JointInfo& joint = model::kJoints[static_cast<std::size_t>(j)];
    x[model::kXJoint + j] = joint.upper_rad;
    EXPECT_NEAR(policy::reflex(x)[j], -0.05, 1e-3) << joint.name;
    x[model::kXJoint + j] = joint.lower_rad;
    EXPECT_NEAR(policy::reflex(x)[j], 0.05, 1e-3) << joint.name;
    x[model::kXJoint + j] = 0.5 * (joint.lower_rad + joint.upper_rad);
    EXPECT_NEAR(policy::reflex(x)[j], 0.0, 1e-12) << joint.name;
  }
}

}  // namespace
}  // namespace sanso::firmware
