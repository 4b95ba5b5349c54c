// The MCAP container (mcap.dev specification, version 0): records, chunks without compression, with
// lz4 or zstd.
// Knows nothing of what the messages hold.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace sanso::recording {

struct McapChannel {
  std::string topic, encoding;  // "/joint_states", "cdr"
  std::string schema;           // "sensor_msgs/msg/JointState"
};

/// Calls on_message(channel, log time in ns, bytes) for every message in file order. One chunk is
/// in memory at a time.
/// Throws InputError: not an MCAP file, truncated record, unknown compression, chunk above 256 MB.
void read_mcap_messages(
    const std::string& path,
    const std::function<void(const McapChannel&, std::uint64_t, std::string_view)>& on_message);

/// Writes messages in chunks (zstd) with the summary that viewers look for. The file appears when
/// finish() was called.
class McapWriter {
 public:
  explicit McapWriter(std::string path);
  /// Declares a topic; `definition` is the schema's text (ros2msg). Returns the channel's id.
  std::uint16_t add_channel(const std::string& topic, const std::string& schema,
                            std::string_view definition);
  void write(std::uint16_t channel, std::uint64_t time_ns, std::string_view cdr);
  void finish();  // throws files::WriteError when the file cannot be written

 private:
  void close_chunk();
  std::string path_;
  std::string file_;          // what has been composed so far
  std::string declarations_;  // schema and channel records, repeated in the summary
  std::string chunk_;         // records of the open chunk
  std::string chunk_indexes_;
  std::uint64_t chunk_start_ = 0, chunk_end_ = 0;
  std::uint64_t first_ = ~std::uint64_t{0}, last_ = 0, messages_ = 0;
  std::uint32_t chunks_ = 0;
  std::map<std::uint16_t, std::uint64_t> count_;
};

}  // namespace sanso::recording
