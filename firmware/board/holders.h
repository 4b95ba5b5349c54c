// Who else has a device open: the process that is the other master on the bus, by its number.
#pragma once

#include <string>

namespace sanso::board {

/// "4711 (op3_manager), 4712 (minicom)": processes but this one that have `device` open, as far as
/// this user may look; empty when there is none. Links are followed. Not for the tick.
std::string holders_of(const std::string& device);

}  // namespace sanso::board
