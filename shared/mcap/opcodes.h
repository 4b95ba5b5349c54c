// The MCAP container's marks (mcap.dev specification, version 0), for writer and readers.
#pragma once

#include <cstdint>
#include <string_view>

namespace sanso::mcap {

inline constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);  // first and last bytes of a file

/// What a record is. A record: opcode (u8), length of its content (u64), content.
enum class Opcode : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  statistics = 0x0B,
  metadata = 0x0C,
  metadata_index = 0x0D,
  summary_offset = 0x0E,
  data_end = 0x0F,
};

}  // namespace sanso::mcap
