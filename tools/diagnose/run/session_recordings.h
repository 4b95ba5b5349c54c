// Trials of a learning session as recordings of a base that floats.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/learn/episodes/episode.h"
#include "tools/diagnose/run/diagnose.h"
#include "tools/recording/recording.h"

namespace sanso::diagnose {

/// What the controller said of every tick, until the base leans too far to be anything but falling:
/// time, goals as sent, joints, base, IMU, current, loaded soles. Base positions only of ticks at
/// which it had a pose of them. The truth of an emulated world is left out. Without rows: the trial
/// holds no tick.
recording::Recording recording_of(const learn::Episode& episode);

struct SessionTrials {
  std::vector<recording::Recording> recordings;  // named trial_0001.csv, as people count
  std::vector<std::string> left_out;             // trials that hold too little, and why
};

/// Throws std::runtime_error: no session there, a file that is damaged, a robot on wheels, no trial
/// that holds the rows a recording must have.
SessionTrials read_session(const std::filesystem::path& folder, const GateSettings& settings = {});

/// Writes the trials and the planner's model below `options.out`/session, and names them in
/// `options` in place of the sessions; those of several are told by their number in front. Throws
/// as read_session() does.
void use_sessions(const std::vector<std::filesystem::path>& folders, DiagnoseOptions& options);

}  // namespace sanso::diagnose
