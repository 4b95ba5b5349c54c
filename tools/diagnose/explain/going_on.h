// The simplest prediction there is: every joint goes on as it went. Where a model predicts worse
// than that, its effects describe the recording's energy, not its cause: a rotor so heavy that
// torque does not matter is praised by every other measure.
#pragma once

#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {

/// Energy by shot of one joint's positions at constant velocity: the start of the shot free within
/// the deviations of the smoothed motion, as for a model. Zero where its position is not compared.
Eigen::VectorXd going_on_energy(const Problem& problem, std::size_t joint);

/// The same of a model with prediction error `r`: r' M r over the rows of that joint's positions.
Eigen::VectorXd position_energy(const Surroundings& around, const Eigen::VectorXd& r,
                                std::size_t joint);

}  // namespace sanso::diagnose
