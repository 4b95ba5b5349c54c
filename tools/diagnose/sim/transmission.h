// What of a joint's transmission remembers. Its laws: transmission_step.h.
#pragma once

#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

/// The joint remembers more than position and velocity.
bool has_memory(const JointParams& joint);
/// Its transmission does; what a servo remembers does not depend on that.
bool gears_remember(const JointParams& joint);

}  // namespace sanso::diagnose
