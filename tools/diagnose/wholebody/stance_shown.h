// What the balances of drives and links leave, for people to look at: over time, and as a torque
// that the model's drive lacks, joint by joint. No verdict rests on it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/diagnose/verdict/missing_torque.h"

namespace sanso::diagnose {

struct DriveRows;

struct StanceShown {
  /// RMS of what a window leaves, in deviations that are known beforehand.
  struct Moment {
    std::size_t recording = 0;
    double t = 0.0, nominal = 0.0, patched = 0.0;  // t: s, middle
  };
  std::vector<Moment> moments;
  // a sample a window and joint: what the joint lacks, if it is all there that something is missing
  std::vector<TorqueSample> nominal, patched;
};

/// `named`: figures of what was found.
StanceShown stance_shown(const DriveRows& rows, const Eigen::VectorXd& named);

}  // namespace sanso::diagnose
