// The parts of model.toml, for writers that put more between them (whole_body.cpp).
#pragma once

#include <string>

#include "tools/diagnose/model_folder/model_folder.h"

namespace sanso::diagnose {

std::string robot_text(const ModelFolder& model);    // up to the last joint
std::string ground_text(const ModelFolder& model);   // [ground]
std::string effects_text(const ModelFolder& model);  // [[effect]]

}  // namespace sanso::diagnose
