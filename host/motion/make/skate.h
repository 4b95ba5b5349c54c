// `sanso motions skate`: the motions on wheels, made from their figures and a ground profile alone.
#pragma once

#include <string>
#include <vector>

#include "host/motion/make/import.h"
#include "shared/model/ground.h"

namespace sanso::motion {

std::vector<std::string> skate_names();

/// The motion of that name, as its file holds it. Throws MotionError naming those there are, or
/// saying what keeps the robot from arriving.
ImportedMotion make_skate(const std::string& name);

/// A robot in one posture on wheels that roll along `ground`, from x = 0 at rest: pushed evenly to
/// its speed, then by the law of energy. The trunk keeps its angle to the line through both axles:
/// on a slope on which the robot coasts, the force felt is normal to the surface.
Trajectory roll(const Skate& skate, const model::Ground& ground);

}  // namespace sanso::motion
