// `sanso motions record`: an emulated robot that oscillators move while a hand holds its torso, and
// the primitives of what it really did.
#pragma once

#include <string>

#include "host/motion/make/import.h"
#include "host/motion/make/oscillators.h"
#include "host/motion/motion.h"

namespace sanso::inprocess {

struct RecordedMotion {
  motion::Motion motion;
  motion::Trajectory robot;   // what was measured: the whole episode, from the push on
  motion::Trajectory wanted;  // what the primitives were fitted to: that, or the mean cycle
  motion::FitError fit;
  double peak_joint_speed = 0.0, joint_margin_rad = 0.0;
  double largest_lag_rad = 0.0;  // measured joint behind its target
};

/// `world` without ground and feet; `ground` empty: the motion's. Throws motion::MotionError when
/// the robot falls in the hand, or does what it could not repeat (joint speeds, limits).
RecordedMotion record_motion(const motion::RecordRecipe& recipe, const motion::Motion& like,
                             const std::string& name, const std::string& world,
                             const std::string& ground);

}  // namespace sanso::inprocess
