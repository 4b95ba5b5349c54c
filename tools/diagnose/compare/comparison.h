// What is compared with what: recordings as drives, their smoothed motion, shots, channels with
// noise, held-out groups. Made once (problem.h), never changed.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "tools/diagnose/gate/gate.h"
#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/diagnose/settings.h"
#include "tools/diagnose/sim/drive.h"
#include "tools/diagnose/sim/simulator.h"

namespace sanso::diagnose {

enum class Signal { q, dq, tau, i, pwm };
/// As columns of a recording begin: "q", "dq", "tau", "i", "pwm".
const char* to_string(Signal signal);

/// One compared channel: a signal of one joint, and what is known of its readings.
struct Observed {
  Signal signal = Signal::q;
  std::size_t joint = 0;
  // unit of the signal; measurement noise, or the trust floor of the settings when that is larger
  double floor = 1.0;
  double noise = 1.0;    // unit of the signal; measurement noise alone
  double quantum = 0.0;  // unit of the signal; step of its readings, 0: none found
};

/// The recorded values of a signal; empty: not recorded.
const std::vector<double>& column(const JointData& data, Signal signal);

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
  std::size_t source = 0;
  Window window;
  std::size_t stride = 1;  // every stride-th row is compared
  std::size_t offset = 0;  // first entry in the stacked residual
  // compared rows; the shot owns channels x rows entries, channel by channel
  std::size_t rows = 0;
  std::size_t group = 0;      // held-out group
  std::size_t condition = 0;  // index of the condition
};

/// What is compared: recordings, channels, shots. Never changes once it is made. Errors of a model
/// are stacked: channel c and compared row k of shot s at shots[s].offset + c * rows + k (rows_of).
struct Comparison {
  Settings settings;
  std::vector<std::string> joints;
  std::vector<Source> sources;
  std::vector<Observed> channels;
  std::vector<Shot> shots;
  std::size_t size = 0;  // length of the stacked residual
  std::size_t groups = 1, conditions = 1;
  double used_share = 1.0;  // of the recorded time that the shots cover
  // s before a shot from which what joints remember is followed; infinite: from the beginning
  double recalled_s = kNone;
  // s on the recordings' clocks: around them all recordings' shots are compared
  std::vector<double> instants;
  std::vector<std::size_t> struck;  // joints whose errors stand alone there
};

/// The compared rows of one channel in one shot, or of `channels` that follow each other: a piece
/// of a stacked vector, valid as long as the vector.
template <class Stacked>
auto rows_of(Stacked&& stacked, const Shot& shot, std::size_t channel, std::size_t channels = 1) {
  return stacked.segment(static_cast<Eigen::Index>(shot.offset + channel * shot.rows),
                         static_cast<Eigen::Index>(channels * shot.rows));
}
/// The same rows of a matrix with a stacked vector in every column.
template <class Stacked>
auto block_of(Stacked&& stacked, const Shot& shot, std::size_t channel, std::size_t channels = 1) {
  return stacked.middleRows(static_cast<Eigen::Index>(shot.offset + channel * shot.rows),
                            static_cast<Eigen::Index>(channels * shot.rows));
}
/// Row of the recording that is compared as the shot's k-th.
inline std::size_t recorded_row(const Shot& shot, std::size_t k) {
  return shot.window.first + (k + 1) * shot.stride;
}

/// The shot that begins within 1.5 times its length of the instant `t` [s, the recording's clock]:
/// the one that holds it and the ones before and after it. When an event ends is seen in its
/// successor.
bool near_instant(const Comparison& comparison, const Shot& shot, double t);

/// Rows of one joint that are compared in all shots together: the unit of "noise levels over a
/// joint's data".
double rows_of_a_joint(const Comparison& comparison);
/// Duration of the longest recording, s.
double longest_recording(const Comparison& comparison);

/// A channel's measured values by row; NaN where it was not sampled.
class MeasuredColumn {
 public:
  MeasuredColumn(const Source& source, const Observed& channel)
      : values_(column(source.drive.joints[channel.joint], channel.signal)),
        command_(source.drive.joints[channel.joint].command),
        electrical_(channel.signal != Signal::q && channel.signal != Signal::dq) {}
  /// In the channel's unit; NaN beyond the end, and of an actuator that is off.
  double at(std::size_t row) const {
    if (row >= values_.size()) return NAN;
    // an actuator that is off reports duty and current of its own convention
    if (electrical_ && row < command_.size() && std::isnan(command_[row])) return NAN;
    return values_[row];
  }

 private:
  const std::vector<double>&values_, &command_;
  bool electrical_;
};
/// A row's measured value of a channel.
double measured(const Source& source, const Observed& channel, std::size_t row);

}  // namespace sanso::diagnose
