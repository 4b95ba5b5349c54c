// Predictions of a model folder against recordings, by horizon and channel.
#include "tools/diagnose/run/score.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "shared/files/input_error.h"
#include "tools/diagnose/compare/measured_motion.h"
#include "tools/diagnose/effects/from_model.h"
#include "tools/diagnose/verdict/heldout.h"
#include "tools/recording/mcap_recording.h"

namespace sanso::diagnose {
namespace {

constexpr std::array<double, 4> kSeconds{kHorizons_s[0], kHorizons_s[1], kHorizons_s[2],
                                         std::numeric_limits<double>::infinity()};

/// Sum of squared differences and their number, by channel.
struct Sum {
  double squares = 0.0;
  std::size_t count = 0;
  double rmse() const { return count == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(count)); }
};

/// Adds one window of one channel; the first row is the start and no prediction.
void add(Sum& sum, const std::vector<double>& measured, std::span<const double> predicted,
         std::size_t first, const std::vector<double>* only_when_on) {
  for (std::size_t k = 1; k < predicted.size(); ++k) {
    const std::size_t row = first + k;
    if (!std::isfinite(measured[row])) continue;
    if (only_when_on != nullptr && !std::isfinite((*only_when_on)[row])) continue;
    sum.squares += (measured[row] - predicted[k]) * (measured[row] - predicted[k]);
    ++sum.count;
  }
}

/// The measured columns of a joint that the model predicts.
struct Compared {
  std::string prefix;
  std::vector<double> JointData::*measured;
  std::vector<double> Prediction::*predicted;
  bool effort;    // means nothing while the actuator is off
  bool position;  // of the score that is told of all joints
};
std::vector<Compared> compared_channels(Actuator actuator) {
  std::vector<Compared> all{{"q:", &JointData::q, &Prediction::q, false, true},
                            {"dq:", &JointData::dq, &Prediction::dq, false, false}};
  if (actuator == Actuator::dc_servo || actuator == Actuator::torque)
    all.push_back({"tau:", &JointData::tau, &Prediction::tau, true, false});
  if (actuator == Actuator::dc_servo) {
    all.push_back({"i:", &JointData::i, &Prediction::i, true, false});
    all.push_back({"pwm:", &JointData::pwm, &Prediction::pwm, true, false});
  }
  return all;
}

HorizonScore score_horizon(const SimParams& params, const Drive& drive,
                           const MeasuredMotion& motion, double seconds) {
  const std::vector<Window> windows = tiled_windows(drive, motion, seconds);
  SimOptions options;
  options.motion = &motion;
  const std::vector<Prediction> predictions = simulate(params, drive, windows, options);
  HorizonScore out;
  Sum positions;
  for (std::size_t j = 0; j < drive.joints.size(); ++j) {
    const JointData& data = drive.joints[j];
    for (const Compared& channel : compared_channels(params.joints[j].nominal.actuator)) {
      const std::vector<double>& measured = data.*channel.measured;
      if (measured.empty()) continue;
      Sum sum;
      for (const Prediction& p : predictions) {
        add(sum, measured, p.of(p.*channel.predicted, j), p.first,
            channel.effort && !data.command.empty() ? &data.command : nullptr);
      }
      out.channels[channel.prefix + params.tree.joints[j].name] = sum.rmse();
      if (channel.position) {
        positions.squares += sum.squares;
        positions.count += sum.count;
      }
    }
  }
  out.rmse = positions.rmse();
  return out;
}

/// A recording with the model that holds for it, ready to be predicted.
struct Prepared {
  Drive drive;
  SimParams params;
  MeasuredMotion motion;
};
Prepared prepare(const ModelFolder& model, const recording::Recording& recording,
                 const Settings& settings) {
  require_fixed_base(model, "sanso score");
  const ModelFolder here = with_overrides(model, recording);
  Prepared out;
  out.drive = make_drive(recording, here);
  out.params = params_with_effects(here, settings.simulation);
  out.motion = measured_motion(out.drive, settings);
  return out;
}

}  // namespace

RecordingScore score(const ModelFolder& model, const recording::Recording& recording,
                     const Settings& settings) {
  const Prepared p = prepare(model, recording, settings);
  RecordingScore out;
  out.file = recording.file;
  for (std::size_t h = 0; h < kSeconds.size(); ++h)
    out.horizons[h] = score_horizon(p.params, p.drive, p.motion, kSeconds[h]);
  return out;
}

std::vector<double> window_errors(const ModelFolder& model, const recording::Recording& recording,
                                  double seconds, const Settings& settings) {
  const Prepared p = prepare(model, recording, settings);
  SimOptions options;
  options.motion = &p.motion;
  std::vector<double> out;
  for (const Prediction& predicted :
       simulate(p.params, p.drive, tiled_windows(p.drive, p.motion, seconds), options)) {
    Sum sum;
    for (std::size_t j = 0; j < p.drive.joints.size(); ++j)
      add(sum, p.drive.joints[j].q, predicted.of(predicted.q, j), predicted.first, nullptr);
    if (sum.count > 0) out.push_back(sum.rmse());
  }
  return out;
}

std::vector<RecordingScore> score_files(const std::string& model_folder,
                                        const std::vector<std::string>& files,
                                        const Settings& settings) {
  const ModelFolder model = read_model_folder(model_folder);
  std::vector<RecordingScore> scores;
  scores.reserve(files.size());
  for (const std::string& file : files)
    scores.push_back(score(model, recording::read_recording(file), settings));
  return scores;
}

std::string score_json(const std::vector<RecordingScore>& scores) {
  nlohmann::ordered_json recordings = nlohmann::ordered_json::array();
  for (const RecordingScore& s : scores) {
    nlohmann::ordered_json horizons;
    for (std::size_t h = 0; h < s.horizons.size(); ++h) {
      horizons[std::string(kHorizonNames[h])] = {{"rmse", s.horizons[h].rmse},
                                                 {"channels", s.horizons[h].channels}};
    }
    recordings.push_back({{"file", s.file}, {"horizons", horizons}});
  }
  return nlohmann::ordered_json{{"recordings", recordings}}.dump(2) + "\n";
}

std::string score_table(const std::vector<RecordingScore>& scores) {
  std::string out =
      "RMSE of the predicted positions, mrad (mm for prismatic joints), restarted from the "
      "measured state\n";
  char line[256];
  std::snprintf(line, sizeof line, "%10s %10s %10s %10s   %s\n", "0.1 s", "0.5 s", "2 s", "whole",
                "recording");
  out += line;
  for (const RecordingScore& s : scores) {
    std::snprintf(line, sizeof line, "%10.3f %10.3f %10.3f %10.3f   ", 1e3 * s.horizons[0].rmse,
                  1e3 * s.horizons[1].rmse, 1e3 * s.horizons[2].rmse, 1e3 * s.horizons[3].rmse);
    out += line + s.file + "\n";
  }
  return out;
}

}  // namespace sanso::diagnose
