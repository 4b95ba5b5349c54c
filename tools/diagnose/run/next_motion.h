// The motion that an OP3 should make next: of squats, sways and leans, the one by which names that
// the recordings leave undecided differ most in a second.
#pragma once

#include <optional>
#include <string>

#include "host/motion/motion.h"
#include "tools/diagnose/verdict/experiment.h"
#include "tools/diagnose/wholebody/names_apart.h"

namespace sanso::diagnose {

struct NextMotion {
  NextExperiment experiment;
  std::optional<motion::Motion> motion;  // nothing: no motion tells them apart
  std::string why_not;                   // then
};

/// Every motion is composed, run on the planner's model of the robot, held against the success
/// clauses of the shipped motion that it is like, and asked what it would tell; then the best one
/// is varied. Seconds. Without a motion where the robot has other joints than the OP3's legs, or
/// where none tells the names apart.
NextMotion next_motion(const NamesApart& apart, const Settings& settings);

}  // namespace sanso::diagnose
