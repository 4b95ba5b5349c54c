// The MCAP container (mcap.dev specification, version 0): records, chunks without compression, with
// lz4 or zstd.
// Knows nothing of what the messages hold.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace sanso::recording {

struct McapChannel {
  std::string topic, encoding;  // "/joint_states", "cdr"
  std::string schema;           // "sensor_msgs/msg/JointState"
};

/// Calls on_message(channel, log time in ns, bytes) for every message in file order. One chunk is
/// in memory at a time. False: the file was cut (its writer lost power, or still writes); the
/// messages of all its complete records have been delivered.
/// Throws InputError: not an MCAP file, damaged record or chunk, unknown compression, chunk above
/// 256 MB.
[[nodiscard]] bool read_mcap_messages(
    const std::string& path,
    const std::function<void(const McapChannel&, std::uint64_t, std::string_view)>& on_message);

}  // namespace sanso::recording
