// The page of a motion: what the robot is asked to do, before it tries. Stick figures, joint angles
// and rates, base and ZMP between the soles, foot heights, success clauses.
#pragma once

#include <string>

#include "host/motion/motion.h"

namespace sanso::report {

/// One self-contained HTML file.
std::string motion_page(const motion::Motion& motion);

}  // namespace sanso::report
