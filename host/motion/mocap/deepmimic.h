// Reader of DeepMimic's motion format: JSON, one row of 44 numbers per key, humanoid with 1-dof
// knees.
// Row: duration [s], root position (3) [m], root quaternion wxyz, chest 4, neck 4, right hip 4,
// right knee 1, right ankle 4, right shoulder 4, right elbow 1, then the same five of the left
// side. x forward, y up, z right.
#pragma once

#include <string>

#include "host/motion/mocap/human_motion.h"

namespace sanso::motion {

/// The legs of the clip, in metres, x forward, y left, z up. Evenly sampled at the first key's
/// duration.
/// Throws ClipError naming file, row and what was expected.
HumanMotion read_deepmimic(const std::string& path);
HumanMotion parse_deepmimic(const std::string& text, const std::string& name);

}  // namespace sanso::motion
