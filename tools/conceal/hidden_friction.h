// Dry friction of a hidden joint, in one of several laws: what it can reach, and what of that it
// puts on the joint now. None is the diagnosis's own.
#pragma once

#include "tools/conceal/hidden_joint.h"

namespace sanso::conceal {

/// Torque that dry friction can reach at this speed, N m; `rest_s` [s] since when it rests.
double friction_level(const JointTruth& joint, double rate, double angle, double motor,
                      double external, double rest_s);

/// Friction torque over one step `h` [s] at constant speed, N m, by the joint's law. `z` [rad] is
/// the bristles' deflection; laws without memory leave it at 0.
double dry_friction(const JointTruth& joint, double rate, double level, double h, double& z);

}  // namespace sanso::conceal
