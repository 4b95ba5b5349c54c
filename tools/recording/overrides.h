// What a sidecar file says was different in one recording: settings by joint and key, payloads.
// Applied to a model by tools/diagnose/model_folder.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace sanso::recording {

/// One setting, as written. `table` is "robot", "control", "joint_default" or "joint.<name>".
struct Override {
  std::string table;
  std::string key;
  std::vector<double> numbers;  // one entry, three for gravity
  std::string text;             // when the value is a string
  int line = 0;                 // in the sidecar, for messages
};

/// A point mass fixed to a link.
struct Payload {
  std::string link;
  double mass = 0.0;                         // kg
  std::array<double, 3> com{0.0, 0.0, 0.0};  // m, in the link's frame
};

}  // namespace sanso::recording
