// From files to judged recordings: reads them, translates reader errors into defects, runs the
// gate.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "shared/files/input_error.h"
#include "tools/diagnose/gate/gate.h"
#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/recording/recording.h"

namespace sanso::diagnose {

/// The gate's view of a recording; valid as long as `recording` lives.
GateRecording gate_view(const recording::Recording& recording);

/// What the gate must know of the model's joints.
std::vector<GateJoint> gate_joints(const ModelFolder& model);

/// A reader's error as a defect of the gate's names where one fits, else under the reader's own
/// name.
Defect defect_of(const files::InputError& error);

struct LoadedRecordings {
  // all files, in the order given; incomplete when `gate` refuses
  std::vector<recording::Recording> recordings;
  GateReport gate;
  std::map<std::string, std::string> hashes;  // see data_hash; of the files as they were
};

/// Reads and judges all files; of channels that are held over several rows one row for each
/// refresh is kept and the others are empty. Never throws for bad input: the reasons stand in
/// `gate.defects`.
LoadedRecordings load_recordings(const std::vector<std::string>& files,
                                 const std::vector<GateJoint>& joints,
                                 const GateSettings& settings = {});

/// File -> FNV-1a of the recording's columns, in hexadecimal: which data a verdict speaks of.
std::map<std::string, std::string> data_hash(const std::vector<recording::Recording>& recordings);

}  // namespace sanso::diagnose
