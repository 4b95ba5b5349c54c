// A stored trial as an MCAP file of ROS 2 messages, as Foxglove and PlotJuggler open it: what the
// black box holds of every tick, and what only the host and the emulated world know.
#pragma once

#include <filesystem>

#include "host/learn/episodes/episode.h"

namespace sanso::exports {

/// Returns the number of messages. Throws files::WriteError, and std::runtime_error when the trial
/// holds no tick.
std::uint64_t write_trial_mcap(const learn::Episode& episode, const std::filesystem::path& file);

}  // namespace sanso::exports
