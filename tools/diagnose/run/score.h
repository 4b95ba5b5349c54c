// How far a model's prediction is from a recording: the judge of every fit claim, and the command
// `sanso score`.
#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/diagnose/settings.h"
#include "tools/recording/recording.h"

namespace sanso::diagnose {

/// Horizons of the table and their names in the JSON; "whole" restarts only once.
inline constexpr std::array<std::string_view, 4> kHorizonNames{"0.1", "0.5", "2", "whole"};

struct HorizonScore {
  double rmse = 0.0;                       // over the position channels of all joints, rad (m)
  std::map<std::string, double> channels;  // "q:knee" -> RMSE in the channel's unit
};

struct RecordingScore {
  std::string file;
  std::array<HorizonScore, 4> horizons;  // in the order of kHorizonNames
};

/// Simulates the recording with the model (its effects and the recording's sidecar applied),
/// restarted from the measured state at every horizon, and compares with every measured channel
/// that the model predicts: q, dq, tau (torque actuators and dc_servo), i and pwm (dc_servo).
/// Samples while an actuator is off are left out of tau, i and pwm. Throws files::InputError.
/// `settings`: how the motion is smoothed.
RecordingScore score(const ModelFolder& model, const recording::Recording& recording,
                     const Settings& settings = {});

/// RMS of the predicted positions' errors (all joints, rad or m) of every window of `seconds` [s]
/// that is restarted from the measured state, in order of time. Throws files::InputError.
std::vector<double> window_errors(const ModelFolder& model, const recording::Recording& recording,
                                  double seconds, const Settings& settings = {});

/// The command: reads everything first, so that bad input writes nothing. Throws
/// files::InputError.
std::vector<RecordingScore> score_files(const std::string& model_folder,
                                        const std::vector<std::string>& files,
                                        const Settings& settings = {});

/// {"recordings": [{"file", "horizons": {"0.1": {"rmse", "channels"}, ...}}]}, units of the scores.
std::string score_json(const std::vector<RecordingScore>& scores);
/// A table for people: one row a recording, RMSE of the positions in mrad (mm) by horizon.
std::string score_table(const std::vector<RecordingScore>& scores);

}  // namespace sanso::diagnose
