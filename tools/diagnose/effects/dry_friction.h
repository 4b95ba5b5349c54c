// Over which angle dry friction builds up: what presliding and Maxwell friction add to Coulomb's.
#pragma once

#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

/// Angle [rad] over which a joint's dry friction builds up after a reversal: the mean over its
/// parts, weighed by their torques. The bristle under all Coulomb friction F bends by F times its
/// compliance (Canudas de Wit 1995, at rest), a Maxwell element by its limit over its stiffness.
/// 0: all of it slips at once, or there is none.
double bend_of_dry_friction(const JointParams& joint);

}  // namespace sanso::diagnose
