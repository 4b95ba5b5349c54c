// Planning problems drawn from the shipped motions: a moment of a motion, a disturbed state, other
// layers, a network.
#pragma once

#include <array>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "host/model/augmented_model.h"
#include "host/motion/motion.h"
#include "host/mpc/cost.h"
#include "host/mpc/stage_context.h"
#include "shared/model/joints.h"

namespace sanso::mpc::problems {

/// A residual network with weights of plausible size: millimetres and centimetres per second.
inline host::ResidualNetwork random_network(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  const auto fill = [&](auto& m, float scale) {
    m = m.NullaryExpr([&] { return scale * normal(random); });
  };
  host::ResidualNetwork n;
  fill(n.W1, 0.15f), fill(n.W2, 0.12f), fill(n.W3, 0.12f), fill(n.b1, 0.1f), fill(n.b2, 0.1f);
  n.output_scale.setConstant(0.001f);
  n.output_scale.tail<model::kNv>().setConstant(0.02f);
  return n;
}

/// Disturbance of a state: centimetres, hundredths of a radian, tenths of the velocities.
inline model::Tangent random_disturbance(std::mt19937& random, double size = 1.0) {
  std::normal_distribution<double> normal;
  model::Tangent d;
  for (int i = 0; i < kNdx; ++i) d[i] = size * normal(random) * (i < model::kNv ? 0.01 : 0.08);
  d[2] *= 0.3;
  return d;
}

/// Context of a plan that starts at `tick` of `reference`; with `middle`, a middle layer of random
/// gains.
inline std::unique_ptr<ProblemContext> make_context(const std::vector<model::State>& reference,
                                                    int tick, int horizon,
                                                    const CostWeights& weights,
                                                    std::mt19937* middle = nullptr) {
  auto c = std::make_unique<ProblemContext>();
  std::normal_distribution<double> normal;
  const auto at = [&](int t) {
    return reference[std::min(static_cast<std::size_t>(t), reference.size() - 1)];
  };
  for (int k = 0; k < horizon; ++k) {
    std::copy_n(at(tick + 6 * k).data(), kNx, c->x_ref[k]);
    if (k + 1 == horizon) break;
    StageContext& s = c->stage[k];
    std::copy_n(at(tick + 6 * k + 3).data() + model::kXJoint, kNu, s.u_fixed);
    std::copy_n(at(tick + 6 * k).data(), kNx, s.x_middle);
    s.has_middle = middle != nullptr;
    if (middle)
      for (auto& row : s.K_middle)
        for (int j = 0; j < kNdx; ++j) row[j] = 0.1 * normal(*middle);
  }
  std::copy_n(weights.state.data(), kNdx, c->state_weight);
  std::copy_n(weights.input.data(), kNu, c->input_weight);
  c->reflex = {true, {0.1, 10.0}, {}, {}};
  for (int i = 0; i < kNu; ++i) {
    c->reflex.lower[i] = model::kJoints[static_cast<std::size_t>(i)].lower_rad;
    c->reflex.upper[i] = model::kJoints[static_cast<std::size_t>(i)].upper_rad;
  }
  return c;
}

/// References of the shipped motions the issue names.
inline std::vector<model::State> reference_of(const std::string& motion) {
  const auto trajectory = motion::MotionLibrary().load(motion).reference();
  return trajectory.x;
}

}  // namespace sanso::mpc::problems
