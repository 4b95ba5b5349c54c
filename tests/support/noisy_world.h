// Small worlds recorded with noise, and compared with a model that does not know what was hidden.
#pragma once

#include <string>
#include <vector>

#include "tests/support/small_comparison.h"

namespace sanso::diagnose::test {

inline constexpr double kPositionNoise = 3e-4;  // rad
inline constexpr const char* kNoisyServo =
    "actuator = \"dc_servo\"\np_gain = 4.0\narmature = 0.01\nposition_noise = 0.0003\n";

inline std::vector<NoiseLevel> noise_of(const ModelFolder& model) {
  std::vector<NoiseLevel> out;
  for (const TreeJoint& joint : model.tree.joints)
    out.push_back({"q:" + joint.name, 0.0, kPositionNoise, {}});
  return out;
}

/// What every joint is asked for in recording number `index`: two sines and a step.
inline double wave(int index, int joint, double t) {
  return 0.6 * std::sin((1.7 + 0.5 * index + 1.3 * joint) * t) +
         0.25 * std::sin((4.3 + 0.8 * index + 2.1 * joint) * t + joint) + (t > 2.0 ? 0.2 : 0.0);
}

/// `count` recordings of `seconds` at 100 Hz of `world`; noise_seed 0: without noise.
inline std::vector<recording::Recording> recordings_of(const ModelFolder& world, int count,
                                                       double seconds, std::uint64_t noise_seed) {
  std::vector<recording::Recording> out;
  for (int k = 0; k < count; ++k) {
    const Drive drive =
        make_test_drive(world, seconds, 0.01, [k](int j, double t) { return wave(k, j, t); });
    Recorded how;
    how.file = "rec_" + std::to_string(k) + ".csv";
    if (noise_seed != 0) how.noise_seed = 1000 * noise_seed + static_cast<std::uint64_t>(k);
    out.push_back(record(world, drive, how));
  }
  return out;
}

/// `model` against recordings of the same robot with `hidden` in it.
inline SmallComparison compared(const ModelFolder& model, const std::vector<EffectEntry>& hidden,
                                const std::vector<std::string>& effects, std::uint64_t noise_seed,
                                int count = 2, double seconds = 4.0) {
  return SmallComparison(model, recordings_of(hiding(model, hidden), count, seconds, noise_seed),
                         noise_of(model), effects);
}

inline EffectEntry hidden(const std::string& id, const std::string& where,
                          const std::map<std::string, double>& parameters) {
  EffectEntry e;
  e.id = id;
  e.where = {where};
  e.parameters = parameters;
  return e;
}

/// The nominal model of a comparison: no effect, every nuisance at its null.
inline Model nominal(const SmallComparison& c) {
  Model m;
  m.nuisance.assign(c.library.nuisances.size(), 0.0);
  return m;
}
inline Model with(const SmallComparison& c, std::size_t candidate,
                  const std::vector<double>& theta) {
  Model m = nominal(c);
  m.effects.push_back({candidate, theta});
  return m;
}

}  // namespace sanso::diagnose::test
