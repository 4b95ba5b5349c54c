// The position loop of a joint, as a model folder states it.
#pragma once

#include <string>

#include "tools/diagnose/model_folder/whole_body.h"

namespace sanso::diagnose {

/// A joint's drive as the model states it, at the output shaft.
struct DriveLaw {
  double stiffness = 0.0, damping = 0.0;  // N m/rad; N m s/rad, all that is proportional to speed
  double torque_constant = 0.0;           // N m/A
  double armature = 0.0, coulomb = 0.0;
  double lag = 0.0, load = 0.0;  // s, from a goal to the loop; friction per torque carried
};

/// Needs a drive that follows a goal (`drive_unknown` empty).
DriveLaw law_of(const JointSettings& joint);

/// Why the law of some drive is not known; empty: those of all joints are.
std::string drive_unknown(const WholeBody& body);

}  // namespace sanso::diagnose
