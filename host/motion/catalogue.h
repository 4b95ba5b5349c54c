// The motions this project ships: which clip, which figures of the retargeting, which weights, what
// counts as success.
#pragma once

#include <string>

#include "host/motion/motion.h"

namespace sanso::motion {

/// Everything of a shipped motion but its primitives, which the import makes from the clip.
/// Throws MotionError naming the motions there are.
Motion catalogue_entry(const std::string& name);

}  // namespace sanso::motion
