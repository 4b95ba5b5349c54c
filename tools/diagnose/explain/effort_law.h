// Torque, current and duty that a model's servo gives where the joint really was: the electrical
// law (residual R4) apart from the motion that the model predicts.
#pragma once

#include <Eigen/Core>

#include "tools/diagnose/compare/candidate.h"

namespace sanso::diagnose {

/// A channel that the servo gives rather than the motion: torque, current, duty.
bool is_effort(Signal signal);

/// (measured - given) / floor of the effort channels, the servo following the recorded positions
/// and velocities as the sensors saw them. Layout of Comparison; entries of the other channels, and
/// rows without a measurement, are 0. A model whose simulated motion drifts is not blamed for its
/// drift here.
Eigen::VectorXd effort_error(const Comparison& comparison, const Library& library,
                             const Model& model);

}  // namespace sanso::diagnose
