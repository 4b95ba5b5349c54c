// Ground profiles (README.md) as the model's ground. The emulated robot reads the same files with
// code of its own.
#pragma once

#include <map>
#include <string>

#include "shared/model/ground.h"

namespace sanso::grounds {

/// "plane", a profile that the program carries ("ramp", ...), or the path of a file. Throws
/// files::InputError.
model::Ground load_ground(const std::string& name_or_path);

/// Text of a profile; `origin` names it in messages. Throws files::InputError.
model::Ground parse_ground(const std::string& toml_text, const std::string& origin);

/// Profiles that the program carries: name and text.
const std::map<std::string, std::string>& built_in_grounds();

}  // namespace sanso::grounds
