// What the sensors of a made world add to a simulation that is itself free of chance.
#pragma once

#include <cmath>
#include <random>

#include "tools/diagnose/sim/simulator.h"

namespace sanso::diagnose::test {

/// In place: noise, reading jitter, encoder steps.
inline void add_sensor_noise(const SimParams& params, std::uint64_t seed, Prediction& prediction) {
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

}  // namespace sanso::diagnose::test
