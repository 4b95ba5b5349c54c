// Trains on the first part of the recordings and is scored on the part held out, the same parts
// as for the diagnosis.
#include "tools/bench/diagnose/residual_network.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "tools/bench/diagnose/perceptron.h"
#include "tools/diagnose/gate/load.h"
#include "tools/diagnose/stats/significance.h"
#include "tools/diagnose/verdict/heldout.h"

namespace sanso::bench {
namespace {

using namespace diagnose;
using Eigen::Index;

constexpr double kHorizon = 0.5;  // s
constexpr int kOwnFeatures = 9, kOtherFeatures = 3;

/// Rows of one joint: features by column, the error to be learned, the time since the shot's start.
struct Rows {
  Eigen::MatrixXd x;
  Eigen::RowVectorXd y, gate;
  std::vector<Index> shot_ends;  // one past the last row of every shot
};

/// Nominal predictions of all shots, in order.
std::vector<Prediction> nominal_predictions(const Comparison& comparison) {
  std::vector<Prediction> out;
  for (std::size_t s = 0; s < comparison.sources.size(); ++s) {
    std::vector<Window> windows;
    for (const Shot& shot : comparison.shots) {
      if (shot.source == s) windows.push_back(shot.window);
    }
    const Source& source = comparison.sources[s];
    SimOptions options;
    options.motion = &source.motion;
    options.max_step_s = comparison.settings.fitting.search_step;
    for (Prediction& p : simulate(source.nominal, source.drive, windows, options))
      out.push_back(std::move(p));
  }
  return out;
}

/// The last command of a joint up to this row, 0 where it has none.
double goal(const JointData& data, std::size_t row) {
  return row < data.command.size() && std::isfinite(data.command[row]) ? data.command[row] : 0.0;
}

void add_features(const Source& source, const Shot& shot, const Prediction& p, std::size_t joint,
                  std::size_t local, Eigen::Ref<Eigen::VectorXd> x) {
  const std::size_t row = shot.window.first + local;
  const double u = goal(source.drive.joints[joint], row),
               u_before = goal(source.drive.joints[joint], row - 1);
  const double q = p.of(p.q, joint)[local];
  x.head(kOwnFeatures) << q, p.of(p.dq, joint)[local], p.of(p.tau, joint)[local], u, u - q,
      u - u_before, shot.window.q[joint], shot.window.dq[joint],
      source.drive.t[row] - source.drive.t[shot.window.first];
  Index next = kOwnFeatures;
  for (std::size_t other = 0; other < source.drive.joints.size(); ++other) {
    if (other == joint) continue;
    x.segment(next, kOtherFeatures) << p.of(p.q, other)[local], p.of(p.dq, other)[local],
        p.of(p.tau, other)[local];
    next += kOtherFeatures;
  }
}

/// The rows of a channel in the chosen shots.
Rows rows_of(const Comparison& comparison, const std::vector<Prediction>& predictions,
             std::size_t channel, const std::vector<std::size_t>& shots) {
  const std::size_t joint = comparison.channels[channel].joint;
  const auto features =
      static_cast<Index>(kOwnFeatures + kOtherFeatures * (comparison.joints.size() - 1));
  Index count = 0;
  for (const std::size_t s : shots) count += static_cast<Index>(comparison.shots[s].rows);
  Rows out{Eigen::MatrixXd(features, count),
           Eigen::RowVectorXd::Zero(count),
           Eigen::RowVectorXd::Zero(count),
           {}};
  Index at = 0;
  for (const std::size_t s : shots) {
    const Shot& shot = comparison.shots[s];
    const Source& source = comparison.sources[shot.source];
    for (std::size_t k = 0; k < shot.rows; ++k, ++at) {
      const std::size_t row = recorded_row(shot, k), local = row - shot.window.first;
      add_features(source, shot, predictions[s], joint, local, out.x.col(at));
      const double error = measured(source, comparison.channels[channel], row) -
                           predictions[s].of(predictions[s].q, joint)[local];
      out.y[at] = std::isfinite(error) ? error : 0.0;
      out.gate[at] = out.x(kOwnFeatures - 1, at) / kHorizon;
    }
    out.shot_ends.push_back(at);
  }
  return out;
}

struct Division {
  std::vector<std::size_t> train, validation, test;
};

/// What the diagnosis' proof holds out is for the test; of the rest the last recording, or where
/// there is one only its last quarter, stops the training.
Division divide(const Comparison& comparison, const Split& split) {
  const auto within = [&](const Shot& shot, const Part& part) {
    const std::size_t s = shot.source;
    const std::vector<double>& t = comparison.sources[s].drive.t;
    const double length = std::max(t.back() - t.front(), 1e-9);
    return (t[shot.window.first] - t.front()) / length >= part.from[s] - 1e-9 &&
           (t[shot.window.last] - t.front()) / length <= part.until[s] + 1e-9;
  };
  Division out;
  for (std::size_t i = 0; i < comparison.shots.size(); ++i) {
    if (within(comparison.shots[i], split.heldout)) out.test.push_back(i);
    if (within(comparison.shots[i], split.fitted)) out.train.push_back(i);
  }
  if (out.train.empty()) return out;
  const std::size_t last = comparison.shots[out.train.back()].source;
  const auto of_last = std::find_if(out.train.begin(), out.train.end(), [&](std::size_t i) {
    return comparison.shots[i].source == last;
  });
  const auto quarter = out.train.end() - static_cast<std::ptrdiff_t>(out.train.size() / 4);
  const auto from = of_last == out.train.begin() ? quarter : of_last;
  out.validation.assign(from, out.train.end());
  out.train.erase(from, out.train.end());
  return out;
}

void score(const Problem& problem, const Division& part, unsigned long seed,
           ResidualNetworkScore& out) {
  const std::vector<Prediction> predictions = nominal_predictions(*problem);
  double before = 0.0, after = 0.0, noise = 0.0, count = 0.0;
  std::vector<double> gain(part.test.size(), 0.0);  // by shot, in noise units
  for (std::size_t c = 0; c < problem->channels.size(); ++c) {
    if (problem->channels[c].signal != Signal::q) continue;
    const Rows train = rows_of(*problem, predictions, c, part.train),
               validation = rows_of(*problem, predictions, c, part.validation),
               test = rows_of(*problem, predictions, c, part.test);
    PerceptronOptions options;
    options.seed = seed;
    Perceptron network;
    network.train(train.x, train.y, train.gate, validation.x, validation.y, validation.gate,
                  options);
    out.epochs = std::max(out.epochs, network.best_epoch());
    const Eigen::RowVectorXd left = test.y - network.predict(test.x, test.gate);
    const auto n = static_cast<double>(left.size());
    before += test.y.squaredNorm(), after += left.squaredNorm();
    noise += problem->channels[c].noise * problem->channels[c].noise * n, count += n;
    const double unit = problem.scales.sigma[c] * problem.scales.sigma[c];
    Index from = 0;
    for (std::size_t s = 0; s < part.test.size(); ++s) {
      const Index rows = test.shot_ends[s] - from;
      gain[s] +=
          (test.y.segment(from, rows).squaredNorm() - left.segment(from, rows).squaredNorm()) /
          unit;
      from = test.shot_ends[s];
    }
  }
  out.ran = count > 0.0;
  if (!out.ran) return;
  out.explained =
      FitScore{std::sqrt(before / count), std::sqrt(after / count), std::sqrt(noise / count)}
          .explained();
  out.mismatch =
      moving_block_lower_bound(gain, problem->settings.decisions.gain_level,
                               problem->settings.decisions.gain_draws, Random(seed)) > 0.0;
}

}  // namespace

ResidualNetworkScore residual_network(const std::string& model_folder,
                                      const std::vector<std::string>& recordings,
                                      unsigned long seed, const Settings& settings) {
  ResidualNetworkScore out;
  try {
    const ModelFolder model = read_model_folder(model_folder);
    const LoadedRecordings loaded = load_recordings(recordings, gate_joints(model));
    if (loaded.gate.refused()) return out;
    const std::vector<Source> sources =
        make_sources(model, loaded.recordings, loaded.gate.noise, settings);
    ProblemOptions options;
    options.shot_seconds = kHorizon;
    options.maximum_rows = 4 * settings.data.maximum_rows;
    options.secondary = false;
    const Problem problem = make_problem(sources, loaded.gate.noise, options, settings);
    const Division part = divide(*problem, make_split(sources));
    if (!part.train.empty() && !part.validation.empty() && !part.test.empty())
      score(problem, part, seed, out);
  } catch (const files::InputError&) {
    out.ran = false;
  }
  return out;
}

}  // namespace sanso::bench
