// Writes the MuJoCo model of the emulated robot and its ground.
#pragma once

#include <string>

#include "tools/plant/world.h"

namespace sanso::plant {

inline constexpr double kPhysicsStep_s = 0.0005;

/// The whole OP3 on the world's ground. Joints carry the URDF's names; bodies are links; geoms
/// named "ground*", "r_sole*", "l_sole*" and the rest (trunk, limbs), which collide with the ground
/// only.
std::string make_mjcf(const World& world);

}  // namespace sanso::plant
