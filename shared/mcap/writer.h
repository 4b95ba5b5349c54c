// Writes an MCAP file front to back: what was handed to the sink is a readable file at any moment,
// finish() adds the index that viewers look for. Chunks are packed with zstd and carry checksums.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sanso::mcap {

class Writer {
 public:
  /// Takes the next bytes of the file, in order. What it throws passes through the Writer, which
  /// is of no further use then.
  using Sink = std::function<void(std::string_view)>;

  /// `chunk_bytes`: a chunk is closed when its messages take so much, before packing.
  explicit Writer(Sink sink, std::size_t chunk_bytes = 1u << 20);
  /// Names and values about the whole file, in front of the messages.
  void add_metadata(const std::string& name, const std::map<std::string, std::string>& values);
  /// Declares a topic of CDR messages; `definition` is the schema's text (ros2msg). Topics of one
  /// schema share it. Returns the channel's id.
  std::uint16_t add_channel(const std::string& topic, const std::string& schema,
                            std::string_view definition);
  /// `time_ns` is both log and publish time.
  void write(std::uint16_t channel, std::uint64_t time_ns, std::string_view cdr);
  /// Hands what has been written so far to the sink, so that it can be read back.
  void close_chunk();
  /// Closes the chunk, writes summary and footer. Nothing may follow.
  void finish();

  std::uint64_t bytes() const { return bytes_; }  // given to the sink
  std::uint64_t messages() const { return messages_; }

 private:
  using Index = std::vector<std::pair<std::uint64_t, std::uint64_t>>;  // time, place in the chunk
  void put(std::string_view bytes);
  std::string statistics() const;

  Sink sink_;
  std::size_t chunk_bytes_;
  std::uint64_t bytes_ = 0;
  std::uint32_t data_crc_ = 0;  // of everything before the summary
  std::map<std::string, std::uint16_t> schema_ids_;
  std::string schemas_, channels_;  // records, repeated in the summary
  std::string chunk_;               // records of the open chunk
  std::map<std::uint16_t, Index> index_;
  std::string chunk_indexes_, metadata_indexes_;
  std::uint64_t chunk_first_ = 0, chunk_last_ = 0;
  std::uint64_t first_ = 0, last_ = 0, messages_ = 0;
  std::uint32_t chunks_ = 0, metadata_ = 0;
  std::map<std::uint16_t, std::uint64_t> count_;
};

}  // namespace sanso::mcap
