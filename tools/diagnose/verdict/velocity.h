// Does the velocity channel tell the motion of the position channel? A question to the sensors
// alone: no model of the robot takes part (residual R6).
#pragma once

#include <vector>

#include "tools/diagnose/gate/gate.h"
#include "tools/diagnose/settings.h"
#include "tools/diagnose/verdict/missing_torque.h"

namespace sanso::diagnose {

/// One sample a row of every joint with a velocity channel, in the place of a missing torque:
/// `missing` [rad/s, m/s] is the reading less the smoothed motion, less the offset and gain error
/// that a sensor may have (gain within secondary_floor); `sigma` the noise of both. At most
/// velocity_samples a joint, evenly chosen.
std::vector<TorqueSample> velocity_errors(const std::vector<Source>& sources,
                                          const std::vector<NoiseLevel>& noise,
                                          const Settings& settings);

}  // namespace sanso::diagnose
