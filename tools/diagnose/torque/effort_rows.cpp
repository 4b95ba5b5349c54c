// Smooths at the recorded rate, thins afterwards, averages over windows.
#include "tools/diagnose/torque/effort_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/files/input_error.h"
#include "tools/diagnose/compare/measured_motion.h"
#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/effects/from_model.h"
#include "tools/diagnose/gate/checks.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/smoother.h"
#include "tools/recording/reading_error.h"

namespace sanso::diagnose {
namespace {

using recording::Recording;

/// A joint's smoothed motion at every row of the recording.
SmoothedState smoothed(const Recording& recording, const std::string& joint,
                       const Settings& settings) {
  const auto column = recording.find("q:" + joint);
  if (std::count_if(column.begin(), column.end(), [](double q) { return std::isfinite(q); }) < 3) {
    throw recording::ReadingError(recording::ReadFault::missing_channel, recording.file,
                                  recording.header_line, "q:" + joint, "no positions", "",
                                  "the measured position of every movable joint of the URDF");
  }
  const std::vector<double> q = gate::without_glitches(column, nullptr, settings.gate);
  return smooth_position(recording.t, q, position_noise(q), settings.smoother,
                         settings.data.likelihood_rows);
}

/// Mean of the finite values of x in [first, last).
double mean_of(const std::vector<double>& x, std::size_t first, std::size_t last) {
  double sum = 0.0, n = 0.0;
  for (std::size_t k = first; k < last; ++k) {
    if (std::isfinite(x[k])) sum += x[k], n += 1.0;
  }
  return n > 0.0 ? sum / n : std::nan("");
}

/// Speed below which the direction of motion is not known, or the joint is about to stand.
double standing_speed(const SmoothedState& s, const EffortSettings& settings) {
  std::vector<double> speed;
  for (const double v : s.dq) speed.push_back(std::abs(v));
  return std::max(settings.standing_sigmas * median(s.dq_sigma),
                  settings.standing * quantile(speed, 0.95));
}

void fill_joint(EffortRecording& out, std::size_t j, const SmoothedState& s,
                const std::vector<double>& effort, std::size_t stride,
                const EffortSettings& settings) {
  const double standing = standing_speed(s, settings);
  for (std::size_t n = 0; n < out.t.size(); ++n) {
    const std::size_t k = n * stride;
    out.motion[n].q[j] = s.q[k];
    out.motion[n].dq[j] = s.dq[k];
    out.motion[n].ddq[j] = s.ddq[k];
    out.moves[j].push_back(std::abs(s.dq[k]) > standing ? 1 : 0);
    const std::size_t half = stride / 2;
    out.effort[j].push_back(effort.empty() ? std::nan("")
                                           : mean_of(effort, k - std::min(k, half),
                                                     std::min(effort.size(), k + stride - half)));
  }
}

EffortRecording read(const ModelFolder& model, const Recording& recording, bool free_gain,
                     const Settings& settings) {
  recording::require_increasing_time(recording);
  EffortRecording out;
  out.file = recording.file;
  out.condition = recording.condition;
  out.nominal = params_with_effects(with_overrides(model, recording), settings.simulation);
  out.channels = effort_channels(recording, out.nominal, free_gain);
  const std::size_t joints = out.channels.size();
  const double interval = gate::sampling_interval(recording.t);
  const auto stride = static_cast<std::size_t>(
      std::max(1.0, std::round(1.0 / (settings.data.fastest_rate * interval))));
  for (std::size_t k = 0; k < recording.t.size(); k += stride) out.t.push_back(recording.t[k]);
  out.motion.resize(out.t.size());
  out.effort.resize(joints), out.moves.resize(joints);
  std::vector<SmoothedState> states(joints);
  parallel_for(joints, [&](std::size_t j) {
    states[j] = smoothed(recording, out.nominal.tree.joints[j].name, settings);
  });
  for (std::size_t j = 0; j < joints; ++j) {
    fill_joint(out, j, states[j], out.channels[j].effort, stride, settings.effort);
    out.channels[j].effort.clear();
  }
  InverseEffort inverse(out.nominal);
  for (const MotionSample& motion : out.motion) out.nominal_needs.push_back(inverse.at(motion));
  return out;
}

/// Rows of one window; a joint that stands, or whose effort is not known, has none.
void add_window(EffortRows& all, std::size_t r, std::size_t first, std::size_t last,
                std::size_t block) {
  const EffortRecording& recording = all.recordings[r];
  for (std::size_t j = 0; j < recording.channels.size(); ++j) {
    if (!recording.channels[j].known) continue;
    EffortRow row{r, j, first, last, block};
    bool whole = true;
    for (std::size_t k = first; k < last; ++k) {
      whole = whole && recording.moves[j][k] != 0 && std::isfinite(recording.effort[j][k]);
      row.effort += recording.effort[j][k];
      row.nominal += recording.nominal_needs[k][j].total();
    }
    const auto n = static_cast<double>(last - first);
    row.effort /= n, row.nominal /= n;
    if (whole && std::isfinite(row.nominal)) all.rows.push_back(row);
  }
}

/// `block`: length of a block, s.
void cut(EffortRows& all, std::size_t r, double block_s, const EffortSettings& settings) {
  const EffortRecording& recording = all.recordings[r];
  const std::vector<double>& t = recording.t;
  const double begin = t.front() + settings.ends, end = t.back() - settings.ends;
  const std::size_t first_block = all.blocks;
  for (std::size_t first = 0; first < t.size();) {
    std::size_t last = first + 1;
    while (last < t.size() && t[last] - t[first] < settings.window - 1e-9) ++last;
    if (t[first] >= begin && t[last - 1] <= end) {
      const std::size_t block =
          first_block + static_cast<std::size_t>((t[first] - begin) / block_s);
      while (all.blocks <= block) ++all.blocks, all.recording_of_block.push_back(r);
      add_window(all, r, first, last, block);
    }
    first = last;
  }
}

void note_channels(EffortRows& all) {
  const EffortRecording& first = all.recordings.front();
  for (std::size_t j = 0; j < first.channels.size(); ++j) {
    const EffortChannel& c = first.channels[j];
    const std::string& name = first.nominal.tree.joints[j].name;
    if (!c.known) {
      all.notes.push_back("effort of " + name + ": none recorded, its torque is not predicted");
      continue;
    }
    std::size_t rows = 0;
    for (const EffortRow& row : all.rows) rows += row.joint == j ? 1 : 0;
    all.notes.push_back(fmt::format("effort of {}: {}, {}{} windows in motion", name,
                                    c.column.empty() ? "none, the joint is passive" : c.column,
                                    c.gain_unknown ? "its gain unknown, " : "", rows));
  }
}

}  // namespace

EffortRows effort_rows(const ModelFolder& model, const std::vector<Recording>& recordings,
                       bool free_gain, const Settings& settings) {
  if (model.floating) {
    throw files::InputError(model.folder, 0, "robot.base", "floating base", "floating",
                            "a fixed base (\"fixed\")");
  }
  EffortRows out;
  double seconds = 0.0;
  for (const Recording& r : recordings) {
    out.recordings.push_back(read(model, r, free_gain, settings));
    seconds += out.recordings.back().t.back() - out.recordings.back().t.front();
  }
  const double block = std::max(settings.effort.block, seconds / settings.effort.blocks);
  for (std::size_t r = 0; r < recordings.size(); ++r) cut(out, r, block, settings.effort);
  if (out.rows.empty()) {
    throw files::InputError(recordings.front().file, recordings.front().header_line,
                            "tau:", "no effort", "",
                            "a joint in motion with tau:, tau_cmd:, force_cmd:, i: or pwm:, or a "
                            "passive one");
  }
  note_channels(out);
  return out;
}

}  // namespace sanso::diagnose
