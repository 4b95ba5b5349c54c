// Picks the command that each joint's actuator follows; a missing column is an InputError that
// names it.
#include "tools/diagnose/sim/drive.h"

#include <algorithm>
#include <cmath>

#include "tools/recording/reading_error.h"

namespace sanso::diagnose {
namespace {

using recording::ReadFault;
using recording::ReadingError;
using recording::Recording;

std::vector<double> column(const Recording& recording, const std::string& name) {
  const auto values = recording.find(name);
  return {values.begin(), values.end()};
}

std::vector<double> command_of(const Recording& recording, const std::string& joint,
                               Actuator actuator) {
  if (actuator == Actuator::passive) return {};
  std::vector<std::string> names{"u:" + joint};
  if (actuator == Actuator::torque) names = {"tau_cmd:" + joint, "force_cmd:" + joint};
  for (const std::string& name : names) {
    if (recording.has(name)) return column(recording, name);
  }
  throw ReadingError(ReadFault::missing_channel, recording.file, recording.header_line, names[0],
                     "no command column", "",
                     "what the actuator '" + std::string(recording::to_string(actuator)) +
                         "' follows, or another actuator in model.toml");
}

}  // namespace

Drive make_drive(const Recording& recording, const ModelFolder& model) {
  recording::require_increasing_time(recording);
  Drive drive;
  drive.name = recording.stem();
  drive.condition = recording.condition;
  drive.t = recording.t;
  drive.volt = column(recording, "volt");
  drive.joints.resize(model.tree.joints.size());
  for (std::size_t j = 0; j < drive.joints.size(); ++j) {
    const std::string& name = model.tree.joints[j].name;
    JointData& data = drive.joints[j];
    data.q = column(recording, "q:" + name);
    if (std::count_if(data.q.begin(), data.q.end(), [](double q) { return std::isfinite(q); }) <
        3) {
      throw ReadingError(
          ReadFault::missing_channel, recording.file, recording.header_line, "q:" + name,
          "no positions", "",
          "the measured position of every movable joint of the URDF, at least three samples; a "
          "joint that was not "
          "recorded can be made type=\"fixed\" in robot.urdf");
    }
    data.command = command_of(recording, name, model.joints[j].actuator);
    data.dq = column(recording, "dq:" + name);
    data.tau = column(recording, "tau:" + name);
    data.i = column(recording, "i:" + name);
    data.pwm = column(recording, "pwm:" + name);
    data.temp = column(recording, "temp:" + name);
  }
  return drive;
}

}  // namespace sanso::diagnose
