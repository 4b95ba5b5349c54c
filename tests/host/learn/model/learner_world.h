// Trials of a robot that is the model with softer servos, for tests of the learner.
#pragma once

#include <random>
#include <vector>

#include "host/learn/model/model_learner.h"
#include "shared/model/op3_step.h"

namespace sanso::learn {

inline constexpr std::uint64_t kSeed = 5;
inline constexpr int kTicks = 300;

// A robot that is the model with softer servos, sampled every 10 ms (its own steps are 10 ms, the
// learner's 60 ms).
// `knee_offset_rad`: its knees stand off from what the controller believes, which no parameter of
// the model can say.
inline Episode episode_of_world(std::uint32_t trial, double stiffness = 0.7,
                                double knee_offset_rad = 0.0) {
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
    model::analytical_step(world, model::make_plane(), x.data(), applied.data(), 0.01, 1, x.data(),
                           scratch);
  }
  return episode;
}

inline model::Tangent weights() {
  model::Tangent w = model::Tangent::Constant(3.0);
  w.segment<3>(0) << 300, 300, 1000;
  w.segment<3>(3) << 60, 60, 20;
  w.segment<12>(24).setConstant(0.02);
  return w;
}

inline std::vector<Episode> episodes(std::uint32_t count, double knee_offset_rad = 0.0) {
  std::vector<Episode> out;
  for (std::uint32_t t = 0; t < count; ++t)
    out.push_back(episode_of_world(t, 0.7, knee_offset_rad));
  return out;
}

}  // namespace sanso::learn
