// Judges an episode by the success clauses of its motion, from the truth where there is one.
#pragma once

#include "host/learn/episodes/episode.h"
#include "host/motion/motion.h"

namespace sanso::app {

/// The episode as somebody outside the controller saw it; without that, as the controller estimated
/// it.
motion::MotionEpisode seen_from_outside(const learn::Episode& episode);

/// Texts of the clauses that the episode breaks.
std::vector<std::string> broken_clauses(const motion::Motion& motion,
                                        const learn::Episode& episode);

}  // namespace sanso::app
