// What the balances of a standing robot leave when all figures are fitted: a push, which comes and
// goes, or something that stays, and at which joint it would be a torque.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/wholebody/drive_rows.h"

namespace sanso::diagnose {

/// A force on the base in neighbouring windows.
struct Push {
  std::size_t recording = 0;
  double from = 0.0, to = 0.0;  // s
  // base axes, N: at the centre of mass the same would be left; who pushes elsewhere pushes in
  // another direction
  V3 force = V3::Zero();
  double beyond = 0.0;  // of what such a force is elsewhere, deviations
};

struct StanceLeft {
  std::vector<Push> pushes;  // strongest first
  std::vector<double> at;    // mean square by place: the base, then the joints; in deviations
};

/// Rows of windows in which nobody pushes.
DriveRows without(const DriveRows& rows, const std::vector<Push>& pushes);

/// `figures`: of the fit. `beyond`: deviations from which on a force is a push.
StanceLeft stance_left(const DriveRows& rows, const Eigen::VectorXd& figures, double beyond);

}  // namespace sanso::diagnose
