// What drives a simulation of one recording: its time stamps, commands, temperatures; and which
// rows to compare with.
#pragma once

#include <vector>

#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/recording/recording.h"

namespace sanso::diagnose {

/// Columns of a recording sorted by joint of the model. Empty vectors where the recording has no
/// such column.
struct JointData {
  // what the actuator follows: goal rad, or torque N m; NaN = actuator off
  std::vector<double> command;
  std::vector<double> q, dq, tau, i, pwm, temp;  // measured; NaN = not sampled
};

struct Drive {
  std::string name;  // of the recording, for messages
  std::string condition;
  std::vector<double> t;          // s, strictly increasing
  std::vector<JointData> joints;  // model order
  std::vector<double> volt;
  std::size_t rows() const { return t.size(); }
};

/// Sorts a recording's columns by the model's joints and checks that they suffice: increasing time,
/// q: of every joint that is not passive and unmeasured, the command that the joint's actuator
/// follows. Throws files::InputError.
Drive make_drive(const recording::Recording& recording, const ModelFolder& model);

}  // namespace sanso::diagnose
