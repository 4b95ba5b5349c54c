// Whether torques and motion belong together: the equations of motion know which column is which,
// where no goal says so.
#pragma once

#include <vector>

#include "tools/diagnose/compare/comparison.h"

namespace sanso::diagnose {

/// Recordings of a robot whose joints are driven by torques, and whose torques fit another reading
/// of the positions far better than the promised one: the other sign, two joints exchanged, another
/// time. Servos' positions follow goals, and the gate sees those.
std::vector<Defect> check_columns(const std::vector<Source>& sources, const Settings& settings);

}  // namespace sanso::diagnose
