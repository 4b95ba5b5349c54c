// What of the transmission remembers.
#include "tools/diagnose/sim/transmission.h"

namespace sanso::diagnose {

bool gears_remember(const JointParams& j) {
  return j.backlash > 0.0 || j.compliance > 0.0 || j.presliding_compliance > 0.0 ||
         j.slip_torque > 0.0 || j.dwell_rate != 0.0;
}

bool has_memory(const JointParams& j) {
  return gears_remember(j) || j.output_filter > 0.0 || j.integral_rate > 0.0 ||
         j.nominal.i_gain > 0.0 || j.profile_speed != kNone || j.profile_acceleration != kNone ||
         j.derating != 0.0 || j.friction_temperature != 0.0 || j.velocity_filter > 0.0;
}

}  // namespace sanso::diagnose
