// Landings, at which a recording is cut for learning.
#pragma once

#include <vector>

#include "shared/wire/messages.h"

namespace sanso::learn {

/// `ticks` (ascending) without landings: gaps, at which windows end and behind which they begin
/// anew. A landing begins when a foot is loaded again after `flight_ticks` or more in which none
/// was, and is over when one has been for as long without a break; 0: none is left out. A small
/// error before a landing decides there between a fall and none, and what a window across it weighs
/// is no longer its error but how far the robot has fallen.
std::vector<wire::Observation> without_landings(const std::vector<wire::Observation>& ticks,
                                                int flight_ticks);

}  // namespace sanso::learn
