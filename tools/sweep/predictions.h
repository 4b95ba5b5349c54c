// What the learned models of two sessions foresee over 0.72 s beside what was recorded: the paper's
// last figure as data.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace sanso::sweep {

struct PredictionOptions {
  std::filesystem::path episode;                // recorded trial, trial_NNNN.episode
  std::vector<std::filesystem::path> sessions;  // whose newest models predict it
  std::string motion = "jog";
  std::filesystem::path out;  // predictions.json
};

/// Writes recorded and predicted base y and three joint angles, restarted from the observed state
/// every 0.72 s.
int run_predictions(const PredictionOptions& options);

}  // namespace sanso::sweep
