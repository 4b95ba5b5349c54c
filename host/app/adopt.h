// What a diagnosis found, put into the planner's model before a session learns.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shared/model/step_model.h"

namespace sanso::app {

struct Adoption {
  std::vector<std::string> adopted;  // "servo_p_gain at l_knee: gain 0.62"
  std::vector<std::string> left;     // the same, with why not
};

/// Findings of a verdict.json that are CONFIRMED, or sets whose names are the same kilograms at the
/// same place, and that the planner's model has a figure for; all others are left. Throws
/// std::runtime_error when the file is no verdict.
Adoption adopt(const std::filesystem::path& verdict, model::ModelParameters& theta);

/// For a person, a line each.
std::string told(const Adoption& adoption);

}  // namespace sanso::app
