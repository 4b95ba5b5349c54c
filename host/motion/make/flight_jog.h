// A jog that flies: a level, even run whose soles are both off the ground for a moment at every
// step. The kinematics alone; rehearse.h finds the targets that make servos do it.
//
// A servo's rotor holds a leg back: seen at the output it weighs more than the leg. Bending the
// knee alone, no leg of the OP3 leaves the ground faster than the trunk falls. So the heel rises
// before lift-off and the foot turns back about its ankle as the knee bends: two joints pull at
// once. Toes that are still up when the swing foot is low put its heel below the ground here; the
// model's contact keeps it out in the rehearsal.
#pragma once

#include "host/motion/flight.h"
#include "host/motion/make/footsteps.h"
#include "host/motion/make/retarget.h"

namespace sanso::motion {

struct FlightReference {
  StepPlan plan;
  Retargeted body;
};

/// Throws ClipError for figures that leave no stance between two flights, or less than two steps.
FlightReference flight_reference(const FlightJog& figures);

}  // namespace sanso::motion
