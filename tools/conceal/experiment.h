// What is done with a hidden robot: commands over time, and under which condition. The same for
// every case of a robot up to its seed, whether an effect is hidden or not.
#pragma once

#include <string>
#include <vector>

#include "tools/conceal/robot_spec.h"

namespace sanso::conceal {

inline constexpr double kControlPeriod_s = 0.01;

struct Experiment {
  std::string name, condition;
  double gain_scale = 1.0;                   // of every P gain, told in the sidecar
  double payload_kg = 0.0;                   // at the payload link's tip, told in the sidecar
  Vec3 gravity{0, 0, -9.81};                 // tilted stand, told in the sidecar
  std::vector<std::vector<double>> command;  // by row, by joint, rad
};

/// Two recordings each of: usual settings, half the P gain, and a payload or a tilted stand.
std::vector<Experiment> make_experiments(const RobotSpec& robot, Random& random);

}  // namespace sanso::conceal
