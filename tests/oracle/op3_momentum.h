// Momentum and energy of the OP3 as a whole: what laws are told in.
#pragma once

#include "shared/model/op3_kinematics.h"
#include "shared/model/step_model.h"

namespace sanso::model {

struct Momentum {
  Vec3 linear;   // kg m/s, world axes
  Vec3 angular;  // kg m^2/s, about the centre of mass, world axes
};
/// Of all bodies; `kin` is that of x. Without armature.
Momentum momentum(const StepModel& model, const Kinematics& kin, const State& x);
/// Kinetic + potential energy [J] without armature; height measured along gravity from the world
/// origin.
double energy(const StepModel& model, const Kinematics& kin, const State& x);

}  // namespace sanso::model
