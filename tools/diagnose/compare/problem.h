// What is compared with what: recordings as drives, their smoothed motion, shots, channels with
// noise, held-out groups.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "tools/diagnose/gate/gate.h"
#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/diagnose/settings.h"
#include "tools/diagnose/sim/drive.h"
#include "tools/diagnose/sim/simulator.h"
#include "tools/recording/recording.h"

namespace sanso::diagnose {

enum class Signal { q, dq, tau, i, pwm };
const char* to_string(Signal signal);

/// One compared channel: a signal of one joint, with the standard deviation that residuals are
/// divided by.
struct Observed {
  Signal signal = Signal::q;
  int joint = 0;
  // unit of the signal; what residuals are divided by: `floor`, or the overdispersed error if
  // larger
  double sigma = 1.0;
  // unit of the signal; measurement noise, or the trust floor of the settings when that is larger
  double floor = 1.0;
  double noise = 1.0;    // unit of the signal; measurement noise alone
  double quantum = 0.0;  // unit of the signal; step of its readings, 0: none found
};

/// One recording, ready to simulate.
struct Source {
  std::string file, condition;
  Drive drive;
  MeasuredMotion motion;
  // deviation of the smoothed motion, by joint, by row
  std::vector<std::vector<double>> q_sigma, dq_sigma;
  SimParams nominal;  // model folder with this recording's sidecar
};

/// A piece of one recording that is simulated from its measured start.
struct Shot {
  int source = 0;
  Window window;
  int stride = 1;          // every stride-th row is compared
  std::size_t offset = 0;  // first entry in the stacked residual
  // compared rows; the shot owns channels x rows entries, channel by channel
  std::size_t rows = 0;
  int group = 0;      // held-out group
  int condition = 0;  // index of the condition
};

/// The stacked comparison. Entry of channel c and compared row k of shot s: shots[s].offset + c *
/// rows + k.
struct Problem {
  Settings settings;
  std::vector<std::string> joints;
  std::vector<Source> sources;
  std::vector<Observed> channels;
  std::vector<Shot> shots;
  std::size_t size = 0;  // length of the stacked residual
  int groups = 1, conditions = 1;
  std::vector<double>
      // natural units, stacked: what the search's step adds to a prediction; empty: not known
      step_error;
  double used_share = 1.0;  // of the recorded time that the shots cover
  // s on the recordings' clocks: around them all recordings' shots are compared
  std::vector<double> instants;
  std::vector<int> struck;  // joints whose errors stand alone there
};

struct ProblemOptions {
  double shot_seconds = 0.5;
  int maximum_rows = 40000;  // rows x joints
  int maximum_shots = std::numeric_limits<int>::max();
  // also compare velocity, torque, current and duty where recorded
  bool secondary = true;
  std::vector<double> instants = {};  // Problem::instants: thinning leaves out no shot there
  std::vector<int> struck = {};       // Problem::struck
};

/// Thins fast recordings, smooths the motion, cuts shots, finds noise. `noise` from the gate.
/// Throws files::InputError.
std::vector<Source> make_sources(const ModelFolder& model,
                                 const std::vector<recording::Recording>& recordings,
                                 const std::vector<NoiseLevel>& noise, const Settings& settings);
Problem make_problem(std::vector<Source> sources, const std::vector<NoiseLevel>& noise,
                     const ProblemOptions& options, const Settings& settings);

/// Smooths the motion anew where the instants of readings scatter by `jitter` [s, by joint; 0: the
/// joint stays as it is]: a position that moves past is known less well than one at rest. Shots
/// begin on the new motion.
void resmooth(Problem& problem, const std::vector<double>& jitter);

/// (measured - predicted) / sigma for one shot into `out` (channels x rows); rows without a
/// measurement become 0.
/// `wanted`: by joint, 0: its channels are left as they are; empty: all are written.
void whitened_residual(const Problem& problem, const Shot& shot, const Prediction& prediction,
                       const std::vector<char>& wanted, double* out);

/// The shot that begins within 1.5 times its length of the instant `t` [s, the recording's clock]:
/// the one that holds it and the ones before and after it. When an event ends is seen in its
/// successor.
bool near_instant(const Problem& problem, const Shot& shot, double t);

/// Rows of one joint that are compared in all shots together: the unit of "noise levels over a
/// joint's data".
double rows_of_a_joint(const Problem& problem);
/// Duration of the longest recording, s.
double longest_recording(const Problem& problem);

/// Length of a shot, s: as set, or what the slowest recording needs for the least number of rows.
double shot_seconds(const std::vector<Source>& sources, const DataSettings& settings);

/// A row's measured value of a channel; NaN when it was not sampled.
double measured(const Source& source, const Observed& channel, std::size_t row);

}  // namespace sanso::diagnose
