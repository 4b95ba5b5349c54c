// Jitter of readings, drawn from the seed; called after a simulation that is itself free of chance.
#include <random>

#include "tools/diagnose/sim/simulator.h"

namespace sanso::diagnose {

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
