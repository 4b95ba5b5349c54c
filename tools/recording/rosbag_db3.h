// Recordings as SQLite files of `ros2 bag` (its default storage until ROS 2 Iron): the same
// messages as in an MCAP, in a table.
#pragma once

#include <string>

#include "tools/recording/recording.h"

namespace sanso::recording {

/// Rows and columns as of read_mcap(), messages in the order of their time stamps. Messages that
/// were packed one by one with zstd are unpacked. Throws files::InputError: no SQLite file, not a
/// bag, damaged, no joint states.
Recording read_db3(const std::string& path, std::size_t max_values = 100'000'000);

}  // namespace sanso::recording
