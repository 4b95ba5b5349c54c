// Laws of the share: it rises slowly while the network is right, falls when it is wrong, and
// learns nothing from a fall.
#include "host/learn/model/residual_trust.h"

#include <gtest/gtest.h>

#include "shared/model/op3_step.h"

namespace sanso::learn {
namespace {

const model::StepModel kModel = model::make_step_model(model::nominal_parameters());
const model::Ground kGround = model::make_plane();

model::Tangent weights() { return model::Tangent::Ones(); }

// A network that answers the same everywhere: the base is pushed `rise` (m) up in every step.
host::ResidualNetwork constant_network(double rise) {
  host::ResidualNetwork n;
  n.output_mean[2] = static_cast<float>(rise);
  return n;
}

// Windows of a robot that does what the model says plus `rise` a step, standing.
std::vector<PredictionWindow> recorded(double rise, std::size_t count = kFewestJudgedWindows) {
  const host::ResidualNetwork truth = constant_network(rise);
  model::Input pose;
  pose << 0, 0, 0.56, -1.13, -0.57, 0, 0, 0, -0.56, 1.13, 0.57, 0;
  PredictionWindow w;
  w.x[0] = model::neutral_state();
  w.x[0][2] = 0.5;  // in the air: no contact answers the push
  w.x[0].segment<model::kNumJoints>(model::kXJoint) = pose;
  for (model::Input& u : w.u) u = pose;
  const std::vector<model::State> states = predicted(w, kModel, kGround, &truth);
  std::copy(states.begin(), states.end(), std::begin(w.x));
  return std::vector<PredictionWindow>(count, w);
}

ResidualTrust after(const ResidualTrust& before, const host::ResidualNetwork& network,
                    const std::vector<PredictionWindow>& windows) {
  return judged(before, windows, kModel, kGround, weights(), network);
}

TEST(ResidualTrust, RisesByAQuarterATrialWhileTheNetworkIsRight) {
  const host::ResidualNetwork right = constant_network(0.004);
  ResidualTrust trust;
  for (const double expected : {0.25, 0.5, 0.75, 1.0, 1.0}) {
    trust = after(trust, right, recorded(0.004));
    EXPECT_EQ(trust.share, expected);
  }
}

TEST(ResidualTrust, ANetworkThatIsWrongOnlyWatches) {
  ResidualTrust trust;
  for (int trial = 0; trial < 5; ++trial)
    trust = after(trust, constant_network(-0.004), recorded(0.004));
  EXPECT_EQ(trust.share, 0.0);
  EXPECT_EQ(trust.ceiling, 1.0) << "it was never followed, so it may still turn out right";
}

TEST(ResidualTrust, StopsWhereMoreWouldBeWorse) {
  ResidualTrust trust;
  for (int trial = 0; trial < 5; ++trial)
    trust = after(trust, constant_network(0.008), recorded(0.004));
  EXPECT_EQ(trust.share, 0.5) << "twice too large a correction: half of it is right";
}

TEST(ResidualTrust, AShareIsFoundWhereTheWholeIsWorseThanNone) {
  const auto windows = recorded(0.004);
  const host::ResidualNetwork three_times = constant_network(0.012);
  const double without = n_step_loss(windows, kModel, kGround, weights()),
               whole = n_step_loss(windows, kModel, kGround, weights(), &three_times);
  ASSERT_GT(whole, without);
  const Share best = best_share(windows, kModel, kGround, weights(), three_times, 1.0);
  EXPECT_EQ(best.share, 0.25);
  EXPECT_LT(best.loss, 0.2 * without);
  const Share none = best_share(windows, kModel, kGround, weights(), constant_network(-0.004), 1.0);
  EXPECT_EQ(none.share, 0.0);
  EXPECT_EQ(none.loss, without);
}

TEST(ResidualTrust, WhatWasTooMuchOnceIsNotTriedAgain) {
  const host::ResidualNetwork network = constant_network(0.004);
  ResidualTrust trust{.share = 1.0};
  trust = after(trust, network, recorded(-0.004));
  EXPECT_EQ(trust.share, 0.0);
  trust = after(trust, network, recorded(0.004));
  EXPECT_EQ(trust.share, 0.0);
}

TEST(ResidualTrust, ATrialThatFellJudgesNothing) {
  const ResidualTrust before{.share = 0.5, .ceiling = 0.75};
  const ResidualTrust trust =
      after(before, constant_network(0.004), recorded(-0.004, kFewestJudgedWindows - 1));
  EXPECT_EQ(trust.share, 0.5);
  EXPECT_EQ(trust.ceiling, 0.75);
}

TEST(ResidualTrust, AShareScalesTheCorrection) {
  host::ResidualNetwork n = constant_network(0.004);
  n.W3.setConstant(0.1F);
  n.output_scale.setConstant(0.3F);
  const host::Features f = host::Features::Constant(0.2);
  EXPECT_TRUE(host::residual_output(with_share(n, 0.25), f)
                  .isApprox(0.25 * host::residual_output(n, f), 1e-6));
}

}  // namespace
}  // namespace sanso::learn
