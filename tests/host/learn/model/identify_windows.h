// Windows for tests of the identification: of robots that are the model with other parameters.
#pragma once

#include <random>
#include <vector>

#include "host/learn/model/identify.h"
#include "shared/model/op3_step.h"

namespace sanso::learn {

inline constexpr std::uint64_t kSeed = 11;

// Windows of a robot that is the model with other parameters: standing with bent knees, targets
// moving about that pose.
inline std::vector<PredictionWindow> windows_of_world(const model::ModelParameters& truth,
                                                      int count) {
  const model::StepModel step_model = model::make_step_model(truth);
  const model::Ground ground = model::make_plane();
  model::Input pose;
  // upright, base 0.245 m (ROBOTIS kinematics)
  pose << 0, 0, 0.56, -1.13, -0.57, 0, 0, 0, -0.56, 1.13, 0.57, 0;
  std::mt19937_64 rng(kSeed);
  std::normal_distribution<double> normal;
  std::vector<PredictionWindow> windows;
  model::StepScratch scratch;
  for (int w = 0; w < count; ++w) {
    PredictionWindow window;
    window.trial = static_cast<std::uint32_t>(w);
    model::State x = model::neutral_state();
    x[2] = 0.245;
    x.segment<model::kNumJoints>(model::kXJoint) = pose;
    for (int j = 0; j < model::kNumJoints; ++j) x[model::kXJointRate + j] = 0.3 * normal(rng);
    window.x[0] = x;
    window.u_before = pose;
    for (int k = 0; k < kPredictionSteps; ++k) {
      for (int j = 0; j < model::kNumJoints; ++j) window.u[k][j] = pose[j] + 0.08 * normal(rng);
      const model::Input acts = window.input(k, step_model.target_lag_s);
      model::analytical_step(step_model, ground, x.data(), acts.data(), 0.06, 1, x.data(), scratch);
      window.x[k + 1] = x;
    }
    windows.push_back(window);
  }
  return windows;
}

inline model::Tangent state_weights() {
  model::Tangent w = model::Tangent::Constant(3.0);
  w.segment<3>(0) << 300, 300, 1000;
  w.segment<3>(3) << 60, 60, 20;
  w.segment<12>(24).setConstant(0.02);
  return w;
}

}  // namespace sanso::learn
