// The torque that the model lacks, window by window (residual R3): the constant joint torque that
// best explains the prediction error of a short shot, the shot's start being free. The weak form of
// the momentum balance, with no differentiation.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/compare/candidate.h"

namespace sanso::diagnose {

/// One window of one joint; state and command are means over the window.
struct TorqueSample {
  std::size_t source = 0, joint = 0;
  std::size_t row = 0;  // first row of the window
  double t = 0.0;       // s, middle
  // rad, rad/s, rad/s^2, goal minus position (0: no goal)
  double q = 0.0, dq = 0.0, ddq = 0.0, error = 0.0;
  double motor = 0.0;    // N m that the model's actuator gives
  double missing = 0.0;  // N m
  double sigma = 0.0;    // N m, standard deviation of `missing` from measurement noise
};

/// All joints, all windows that `make_problem` cuts with torque_window. Joints that were not
/// measured are left out.
std::vector<TorqueSample> missing_torque(const std::vector<Source>& sources,
                                         const std::vector<NoiseLevel>& noise,
                                         const Library& library, const Model& model,
                                         const Settings& settings);

}  // namespace sanso::diagnose
