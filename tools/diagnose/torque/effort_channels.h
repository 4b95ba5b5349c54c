// Which column of a recording says what effort a joint's motor gave, and in which unit.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/sim/sim_params.h"
#include "tools/recording/recording.h"

namespace sanso::diagnose {

/// Where a joint's effort comes from.
struct EffortChannel {
  std::string column;  // "tau:knee"; empty: none recorded, or a passive joint
  std::string unit;    // of `effort`: "N m", "N", or "A" where the drive's gain is unknown
  bool known = false;  // an effort is known: recorded, or zero because there is no motor
  // one number stands between the effort and N m, and the model does not state it
  bool gain_unknown = false;
  std::vector<double> effort;  // by row, in `unit`; NaN: not known
};

/// The best column of each joint: `tau:`; `i:` times the torque constant; `pwm:` through the
/// motor's law; of a torque actuator `tau_cmd:` (`force_cmd:`), zero where it is off; `i:` in
/// amperes, or `pwm:`, where no torque constant is stated, if it has a sign; zero for a passive
/// joint. `free_gain`: the scale
/// of every recorded effort is taken as unknown.
std::vector<EffortChannel> effort_channels(const recording::Recording& recording,
                                           const SimParams& params, bool free_gain);

}  // namespace sanso::diagnose
