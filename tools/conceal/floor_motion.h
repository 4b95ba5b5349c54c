// What the robot on a floor is asked to do: goals of its joints over time, soles flat on a floor
// that is flat.
#pragma once

#include <string>

#include "tools/conceal/robot_spec.h"

namespace sanso::conceal {

struct FloorMotion {
  std::string name, condition;
  double squat = 0, sway = 0;  // rad, of knee and hip roll
  // rad: more bend of the leg that the sway unloads, and by how much either hip goes ahead while
  // the leg is up; nothing: both feet stay where they are
  double lift = 0, stride = 0;
  double rate_hz = 0.5;
  double heading = 0;  // rad, in which it stands
};

/// Goal of a joint, rad.
double goal_of(const LinkSpec& link, const FloorMotion& motion, double t);

}  // namespace sanso::conceal
