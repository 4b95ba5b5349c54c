// The residual network: invariance to place and heading, consistency of target and tangent.
#include "host/model/residual_network.h"

#include <gtest/gtest.h>

#include <random>

#include "host/mpc/upper_layer.h"  // compiles on its own

namespace sanso::host {
namespace {

ResidualNetwork random_network(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal(0.0f, 1.0f);
  const auto fill = [&](auto& m, float scale) {
    m = m.NullaryExpr([&] { return scale * normal(random); });
  };
  ResidualNetwork n;
  fill(n.feature_mean, 0.3f);
  n.feature_scale.setConstant(1.7f);
  fill(n.W1, 0.3f), fill(n.W2, 0.2f), fill(n.W3, 0.3f);
  fill(n.b1, 0.3f), fill(n.b2, 0.3f), fill(n.b3, 0.3f);
  fill(n.output_mean, 0.01f);
  n.output_scale.setConstant(0.05f);
  return n;
}

model::State random_state(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 0.4);
  const model::Tangent d = model::Tangent::NullaryExpr([&] { return normal(random); });
  return model::plus(model::neutral_state(), d);
}

TEST(ResidualNetwork, TurningAndMovingTheRobotTurnsTheCorrection) {
  const ResidualNetwork n = random_network(7);
  const model::State x = random_state(7);
  const model::Input u = model::Input::Constant(0.2);
  const math::Quat yaw = math::quat_exp({0, 0, 1.1});
  model::State y = x;
  y.segment<2>(model::kXPos) += Eigen::Vector2d(3.0, -2.0);
  y.segment<4>(model::kXQuat) = math::quat_multiply(yaw, model::base_quat(x));
  y.segment<3>(model::kXVel) = math::rotation_matrix(yaw) * x.segment<3>(model::kXVel);
  const model::Tangent at_x = residual_tangent(n, x, u), at_y = residual_tangent(n, y, u);
  const math::Mat3 R = math::rotation_matrix(yaw);
  EXPECT_LT((R * at_x.segment<3>(model::kDPos) - at_y.segment<3>(model::kDPos)).norm(), 1e-12);
  EXPECT_LT((R * at_x.segment<3>(model::kDVel) - at_y.segment<3>(model::kDVel)).norm(), 1e-12);
  EXPECT_LT((at_x.segment<15>(3) - at_y.segment<15>(3)).norm(), 1e-12);
}

TEST(ResidualNetwork, TargetIsWhatTheTangentUndoes) {
  const model::State x = random_state(1), analytical = random_state(2), measured = random_state(3);
  const model::Tangent target = residual_target(x, analytical, measured);
  // a network that is only its output bias returns the target, and the step then lands on the
  // measured state
  ResidualNetwork n;
  n.output_mean = target.cast<float>();
  const model::State reached =
      model::plus(analytical, residual_tangent(n, x, model::Input::Zero()));
  EXPECT_LT(model::minus(reached, measured).norm(), 1e-6);  // single-precision weights
}

}  // namespace
}  // namespace sanso::host
