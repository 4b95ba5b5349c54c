// The residual network that the diagnosis is compared with: learns what the nominal simulation gets
// wrong, corrects it, names nothing.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/settings.h"

namespace sanso::bench {

struct ResidualNetworkScore {
  bool ran = false;  // false: the data were refused, or nothing was left to train on
  // of the error beyond noise, 0.5 s ahead, on the recordings held out; as in verdict.json
  double explained = 0.0;
  // it predicts the held-out recordings better than the nominal model, beyond chance
  bool mismatch = false;
  int epochs = 0;
};

/// Trains one network a joint on the recordings that the diagnosis fits its proof to, stops early
/// by one of them, and scores on those that the diagnosis holds out. Features of a row: the nominal
/// simulation's position, velocity and torque of every joint there, goal and goal minus position,
/// the shot's start, the time since. The output is multiplied by the time since the start, at which
/// the simulation is right. Nothing measured after the start is a feature.
ResidualNetworkScore residual_network(const std::string& model_folder,
                                      const std::vector<std::string>& recordings,
                                      unsigned long seed, const diagnose::Settings& settings);

}  // namespace sanso::bench
