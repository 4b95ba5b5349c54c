// Zero-moment point: the centre-of-mass path that has a wanted ZMP (linear inverted pendulum), and
// the ZMP that a motion of all bodies really has.
#pragma once

#include <vector>

#include "host/motion/trajectory.h"

namespace sanso::motion {

/// Solves c_i - h / (g dt^2) (c_{i+1} - 2 c_i + c_{i-1}) = p_i for the CoM path c, at rest on p at
/// both ends.
/// `com_height_m` above the ground; one coordinate, same length as `zmp`.
std::vector<double> com_for_zmp(const std::vector<double>& zmp, double com_height_m, double dt_s);

/// ZMP of the point masses of all bodies [facts: sum m ((z''+g) x - x'' z) / sum m (z''+g)], ground
/// at z = 0.
/// Samples where the bodies fall freely (less than a tenth of the weight on the ground) repeat the
/// last one.
struct ZmpSample {
  double x = 0.0, y = 0.0;  // m
  double load = 1.0;        // vertical ground force over weight
};
/// One sample a row of the trajectory, world axes.
std::vector<ZmpSample> zmp_of(const Trajectory& trajectory);

}  // namespace sanso::motion
