// A trial as it would go if the robot were what the planner believes: of nobody's robot, but of the
// same form, so that everything that reads trials reads it.
#pragma once

#include "host/learn/episodes/episode.h"
#include "host/model/augmented_model.h"
#include "host/motion/motion.h"

namespace sanso::app {

/// One observation and one true sample a tick; upper layer and primitives, no noise, no delay,
/// soles on level ground. Ends early by the motion's own stop rule. Currents are not told.
/// Deterministic.
learn::Episode trial_in_model(const motion::Motion& motion, const host::AugmentedModel& model = {});

}  // namespace sanso::app
