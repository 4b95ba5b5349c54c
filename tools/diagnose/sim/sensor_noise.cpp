// Noise, quantum and jitter of readings, drawn from the seed; called after a simulation that is
// itself free of chance.
#include <cmath>
#include <random>

#include "tools/diagnose/sim/simulator.h"

namespace sanso::diagnose {

void add_sensor_noise(const SimParams& params, std::uint64_t seed, Prediction& prediction) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (std::size_t j = 0; j < params.joints.size(); ++j) {
    const JointParams& joint = params.joints[j];
    const double quantum = joint.nominal.position_quantum;
    for (std::size_t k = 0; k < prediction.rows; ++k) {
      const std::size_t at = j * prediction.rows + k;
      double& q = prediction.q[at];
      q += joint.nominal.position_noise * normal(random);
      q += joint.jitter * prediction.dq[at] * normal(random);
      if (quantum > 0.0) q = quantum * std::round(q / quantum);
    }
  }
}

void add_reading_jitter(const SimParams& params, std::uint64_t seed, Prediction& prediction) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (std::size_t j = 0; j < params.joints.size(); ++j) {
    const double jitter = params.joints[j].jitter;
    if (jitter == 0.0) continue;
    for (std::size_t at = j * prediction.rows; at < (j + 1) * prediction.rows; ++at)
      prediction.q[at] += jitter * prediction.dq[at] * normal(random);
  }
}

}  // namespace sanso::diagnose
