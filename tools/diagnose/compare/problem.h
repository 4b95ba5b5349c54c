// A comparison and the units in which its errors are told: one scale a channel, and what the
// search's step adds to predictions. A value: what changes a unit returns a new problem, and the
// comparison is shared.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "tools/diagnose/compare/comparison.h"
#include "tools/recording/recording.h"

namespace sanso::diagnose {

/// What errors are divided by, one standard deviation a channel, unit of the signal.
struct Scales {
  std::vector<double> sigma;
};

/// Stacked, natural units: what the search's step adds to a prediction; empty: not known.
struct StepCorrection {
  Eigen::VectorXd error;
};

struct Problem {
  std::shared_ptr<const Comparison> comparison;
  Scales scales;
  StepCorrection correction = {};
  const Comparison* operator->() const { return comparison.get(); }
  const Comparison& operator*() const { return *comparison; }
};

/// Errors in noise levels (or trust floors): every channel's scale is its floor.
Scales floors(const Comparison& comparison);
/// The problem's scales times the root of every channel's overdispersion, never below the floor.
Scales overdispersed(const Problem& problem, const std::vector<double>& overdispersion);
/// Errors `r` told in `from` (by channel), told in `to`.
Eigen::VectorXd rescaled(const Comparison& comparison, Eigen::VectorXd r, const Scales& from,
                         const Scales& to);

struct ProblemOptions {
  double shot_seconds = 0.5;
  int maximum_rows = 40000;  // rows x joints
  int maximum_shots = std::numeric_limits<int>::max();
  // also compare velocity, torque, current and duty where recorded
  bool secondary = true;
  std::vector<double> instants = {};     // Comparison::instants: thinning leaves out no shot there
  std::vector<std::size_t> struck = {};  // Comparison::struck
};

/// Thins fast recordings, smooths the motion, cuts shots, finds noise. `noise` from the gate.
/// Throws files::InputError.
std::vector<Source> make_sources(const ModelFolder& model,
                                 const std::vector<recording::Recording>& recordings,
                                 const std::vector<NoiseLevel>& noise, const Settings& settings);
/// Scales are the channels' floors; nothing is known of the step.
Problem make_problem(std::vector<Source> sources, const std::vector<NoiseLevel>& noise,
                     const ProblemOptions& options, const Settings& settings);
/// Length of a shot, s: as set, or what the slowest recording needs for the least number of rows.
double shot_seconds(const std::vector<Source>& sources, const DataSettings& settings);

/// The same with the motion smoothed anew where the instants of readings scatter by `jitter` [s, by
/// joint; 0: the joint stays as it is]: a position that moves past is known less well than one at
/// rest. Shots begin on the new motion. Scales and correction stay.
Problem resmoothed(const Problem& problem, const std::vector<double>& jitter);

/// The same with these shots only, in this order; what is known of them goes with them. Joints
/// remember no more than `recalled_s` [s] before a shot.
Problem with_shots(const Problem& problem, const std::vector<std::size_t>& shots,
                   double recalled_s = kNone);

/// Writes (measured - predicted) / sigma of one shot into its rows of the stacked `r`; rows without
/// a measurement become 0.
/// `wanted`: by joint, 0: its channels are left as they are; empty: all are written.
void whiten_residual(const Problem& problem, const Shot& shot, const Prediction& prediction,
                     const std::vector<char>& wanted, Eigen::VectorXd& r);

}  // namespace sanso::diagnose
