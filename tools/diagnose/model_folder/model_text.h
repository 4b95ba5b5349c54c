// The parts of model.toml, for writers that put more between them (whole_body.cpp).
#pragma once

#include <string>

#include "tools/diagnose/model_folder/model_folder.h"

namespace sanso::diagnose {

/// From the beginning up to the last joint.
std::string robot_text(const ModelFolder& model);
/// [ground].
std::string ground_text(const ModelFolder& model);
/// All [[effect]]s.
std::string effects_text(const ModelFolder& model);

}  // namespace sanso::diagnose
