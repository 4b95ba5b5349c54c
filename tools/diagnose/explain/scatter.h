// Effects that are chance: which command is lost, when a reading is taken. No simulation predicts
// what they did in a recording; they are judged by where, and how much, they make recordings
// scatter about a prediction.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "tools/diagnose/explain/scatter_rows.h"
#include "tools/diagnose/fit/fit.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {

/// What one random effect (Effect::random) says about the scatter that a fitted model leaves.
struct ScatterScore {
  std::size_t candidate = 0;
  double size = 0.0, low = 0.0, high = 0.0;  // of its first parameter, 95 % interval over shots
  // more scatter than the largest size of the library makes: something else
  bool beyond = false;
  // correlation of squared error and expected scatter, in deviations under independence
  double score = 0.0;
  // over all random candidates, the larger of two null laws; see judge_scatter
  double p_family = 1.0;
  double energy = 0.0;       // expected in the whole stacked error at `size`, starts eliminated
  double left = INFINITY;    // noise levels in the position error with it, see position_error_level
  Eigen::VectorXd expected;  // the same by entry, whitened squares
};

/// Best first; empty when the library has no random candidate. Compared are second differences
/// within a shot, in which slow errors of the model vanish, with the variance of the effect's own
/// draws. p counts actual draws under two null laws, and the larger one holds: errors shifted
/// against the recording's time (circularly, so that colour and size stay), and simulated readings
/// of the fitted model with the channels' noise and quantisation. Resolves to 1 / (draws + 1).
/// `least_energy`: what makes less even at its largest size is not measured (size, interval and
/// energy stay 0). What leaves far more than noise even so has no interval.
std::vector<ScatterScore> judge_scatter(const Surroundings& around, const FitResult& final,
                                        double least_energy, Random random);

/// Standard deviation of the instants of readings in a model, s, by joint.
std::vector<double> jitter_of(const Comparison& comparison, const Library& library,
                              const Model& model);

}  // namespace sanso::diagnose
