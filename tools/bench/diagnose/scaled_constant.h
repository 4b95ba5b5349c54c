// What half and double of a constant of the diagnosis does to its scores: one constant is scaled
// before the cases are run.
#pragma once

#include <string>
#include <vector>

namespace sanso::bench {

/// Names of all constants in tools/diagnose/constants.h that can be scaled.
std::vector<std::string> constant_names();

/// "kFamilyWise=0.5" halves that constant for the rest of the process; whole numbers are rounded
/// and stay at least 1.
/// Call before any diagnosis runs. Throws std::invalid_argument when the name is unknown or the
/// factor is no positive number.
void scale_constant(const std::string& assignment);

}  // namespace sanso::bench
