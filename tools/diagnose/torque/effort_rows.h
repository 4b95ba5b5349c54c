// Recordings as rows of a regression: the smoothed motion, and the effort that was recorded,
// averaged over short windows.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/diagnose/settings.h"
#include "tools/diagnose/torque/effort_channels.h"
#include "tools/diagnose/torque/inverse_effort.h"

namespace sanso::diagnose {

/// One recording at an even pace; all vectors by joint, then by instant.
struct EffortRecording {
  std::string file, condition;
  SimParams nominal;  // model folder with the recording's sidecar and the model's [[effect]]s
  std::vector<double> t;
  std::vector<MotionSample> motion;                      // by instant
  std::vector<std::vector<NeededEffort>> nominal_needs;  // by instant, by joint
  std::vector<std::vector<double>> effort;               // in the channel's unit; NaN: not known
  std::vector<std::vector<char>> moves;  // 0: at rest, where friction may have any value
  std::vector<EffortChannel> channels;   // by joint; their `effort` is empty here
};

/// A stretch of one recording and one joint, the unit of the regression.
struct EffortRow {
  std::size_t recording = 0, joint = 0;
  std::size_t first = 0, last = 0;  // instants [first, last)
  std::size_t block = 0;            // stretches of effort.block, counted over all recordings
  double effort = 0.0;              // mean recorded, channel's unit
  double nominal = 0.0;             // mean that the nominal model needs, N m
};

struct EffortRows {
  std::vector<EffortRecording> recordings;
  std::vector<EffortRow> rows;
  std::size_t blocks = 0;
  std::vector<std::size_t> recording_of_block;
  std::vector<std::string> notes;
};

/// Reads the motion and the effort. Throws files::InputError where no joint has a known effort, or
/// the base floats.
EffortRows effort_rows(const ModelFolder& model,
                       const std::vector<recording::Recording>& recordings, bool free_gain,
                       const Settings& settings);

}  // namespace sanso::diagnose
