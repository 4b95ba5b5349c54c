// The control socket's language: one JSON object in, one out. What a person beside the robot can do
// (put it back, push it, press a button, pull a plug) and what only an emulator can (read the
// truth, switch faults).
#pragma once

#include <string>

#include "tools/emulator/emulated_robot.h"

namespace sanso::emulator {

/// What a command asks of the process rather than of the robot.
enum class ProcessRequest { none, unplug_bus, replug_bus, quit };

struct ControlAnswer {
  std::string json;
  ProcessRequest request = ProcessRequest::none;
};

/// Carries out one command. A command that cannot be understood answers {"ok": false, "error":
/// ...}, and changes nothing.
ControlAnswer execute_command(EmulatedRobot& robot, const std::string& json);

}  // namespace sanso::emulator
