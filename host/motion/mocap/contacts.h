// Heading, floor and foot contacts of a recorded human: what a gait needs before it can be scaled.
#pragma once

#include <array>
#include <vector>

#include "host/motion/mocap/human_motion.h"

namespace sanso::motion {

/// Turns the motion about the vertical and moves it so that it starts above the origin. By body:
/// mean facing is +x.
/// Else: the travel lies along +x, or along -x when the man walks backwards.
HumanMotion aligned(const HumanMotion& motion, bool heading_by_body);

/// Removes a floor that tilts along x: a line through the running minimum of the lower foot point.
HumanMotion floor_levelled(const HumanMotion& motion);

/// True where a foot carries: low and slow, against its own lowest heights and the speed of the
/// hips.
std::array<std::vector<bool>, 2> foot_contacts(const HumanMotion& motion);

struct HumanStance {
  int side = kRight;
  double from_s = 0.0, to_s = 0.0;  // first and last contact
  bool whole = true;                // false: cut by the start or the end of the clip
  Eigen::Vector2d p{0, 0};          // median place of the ankle   m
};
/// Contacts as stances in the order they begin; shorter than 80 ms is no stance.
std::vector<HumanStance> stances(const HumanMotion& motion);

/// Strings `cycles` copies of a looped clip together.
HumanMotion unrolled(const HumanMotion& motion, int cycles);

}  // namespace sanso::motion
