// Means over the parts of a joint's dry friction.
#include "tools/diagnose/effects/dry_friction.h"

#include <algorithm>

#include "tools/diagnose/sim/transmission_step.h"

namespace sanso::diagnose {

double bend_of_dry_friction(const JointParams& joint) {
  const double coulomb = std::max(0.0, joint.nominal.coulomb + joint.coulomb);
  const double all = coulomb + joint.slip_torque;
  if (!(all > 0.0)) return 0.0;
  double sum = coulomb * coulomb * joint.presliding_compliance;
  if (joint.slip_torque > 0.0 && joint.slip_stiffness > 0.0) {
    for (const double share : portable::slip_shares(joint).share) {
      const double limit = joint.slip_torque * share;
      sum += limit * limit / (joint.slip_stiffness / portable::kSlipElements);
    }
  }
  return sum / all;
}

}  // namespace sanso::diagnose
