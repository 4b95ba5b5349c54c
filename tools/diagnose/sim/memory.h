// When two robots remember the same: what servos and transmissions keep between steps follows from
// the motion as it was measured (follow.h), and most of a robot's figures have no part in it.
#pragma once

#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

/// Following one recording of them gives the same inner states, bit for bit. False may mean that it
/// is not known.
bool remember_alike(const SimParams& a, const SimParams& b);

}  // namespace sanso::diagnose
