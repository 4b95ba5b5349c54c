// Records as mcap.dev's specification lays them out; one chunk and the indexes are in memory.
#include "shared/mcap/writer.h"

#include <algorithm>

#ifdef SANSO_HAVE_ZSTD
#include <zstd.h>
#endif

#include "shared/base/crc32.h"
#include "shared/files/bytes.h"
#include "shared/mcap/opcodes.h"

namespace sanso::mcap {
namespace {

std::string record(Opcode opcode, std::string_view content) {
  files::ByteWriter out;
  out.number(static_cast<std::uint8_t>(opcode));
  out.number(static_cast<std::uint64_t>(content.size()));
  out.raw(content);
  return out.bytes();
}

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

#ifdef SANSO_HAVE_ZSTD
constexpr std::string_view kPacking = "zstd";
std::string pack(std::string_view bytes) {
  constexpr int kFast = 1;
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), kFast));
  return packed;
}
#else  // a target without the library
constexpr std::string_view kPacking;
std::string pack(std::string_view bytes) { return std::string(bytes); }
#endif

/// u32 length in bytes, then the entries.
void put_array(files::ByteWriter& out, const files::ByteWriter& entries) {
  out.string(entries.bytes());
}

}  // namespace

Writer::Writer(Sink sink, std::size_t chunk_bytes)
    : sink_(std::move(sink)), chunk_bytes_(chunk_bytes) {
  files::ByteWriter header;
  header.string("ros2");
  header.string("sanso");
  put(std::string(kMagic) + record(Opcode::header, header.bytes()));
}

void Writer::put(std::string_view bytes) {
  data_crc_ = crc32_more(data_crc_, bytes_of(bytes));
  bytes_ += bytes.size();
  sink_(bytes);
}

void Writer::add_metadata(const std::string& name,
                          const std::map<std::string, std::string>& values) {
  files::ByteWriter pairs, content, index;
  for (const auto& [key, value] : values) {
    pairs.string(key);
    pairs.string(value);
  }
  content.string(name);
  put_array(content, pairs);
  const std::string bytes = record(Opcode::metadata, content.bytes());
  index.number(bytes_);
  index.number(static_cast<std::uint64_t>(bytes.size()));
  index.string(name);
  metadata_indexes_ += record(Opcode::metadata_index, index.bytes());
  ++metadata_;
  put(bytes);
}

std::uint16_t Writer::add_channel(const std::string& topic, const std::string& schema,
                                  std::string_view definition) {
  const auto [known, fresh] =
      schema_ids_.try_emplace(schema, static_cast<std::uint16_t>(schema_ids_.size() + 1));
  if (fresh) {
    files::ByteWriter s;
    s.number(known->second);
    s.string(schema);
    s.string("ros2msg");
    s.string(definition);
    const std::string bytes = record(Opcode::schema, s.bytes());
    schemas_ += bytes;
    chunk_ += bytes;
  }
  const auto id = static_cast<std::uint16_t>(count_.size() + 1);
  files::ByteWriter c;
  c.number(id);
  c.number(known->second);
  c.string(topic);
  c.string("cdr");
  c.number(std::uint32_t{0});  // no metadata
  const std::string bytes = record(Opcode::channel, c.bytes());
  channels_ += bytes;
  chunk_ += bytes;
  count_[id] = 0;
  return id;
}

void Writer::write(std::uint16_t channel, std::uint64_t time_ns, std::string_view cdr) {
  files::ByteWriter m;
  m.number(channel);
  m.number(static_cast<std::uint32_t>(count_[channel]++));
  m.number(time_ns);
  m.number(time_ns);
  m.raw(cdr);
  const bool first_of_chunk = index_.empty();
  chunk_first_ = first_of_chunk ? time_ns : std::min(chunk_first_, time_ns);
  chunk_last_ = first_of_chunk ? time_ns : std::max(chunk_last_, time_ns);
  first_ = messages_ == 0 ? time_ns : std::min(first_, time_ns);
  last_ = std::max(last_, time_ns);
  ++messages_;
  index_[channel].emplace_back(time_ns, chunk_.size());
  chunk_ += record(Opcode::message, m.bytes());
  if (chunk_.size() >= chunk_bytes_) close_chunk();
}

void Writer::close_chunk() {
  if (chunk_.empty()) return;
  const std::string packed = pack(chunk_);
  files::ByteWriter c;
  c.number(chunk_first_);
  c.number(chunk_last_);
  c.number(static_cast<std::uint64_t>(chunk_.size()));
  c.number(crc32(bytes_of(chunk_)));
  c.string(kPacking);
  c.number(static_cast<std::uint64_t>(packed.size()));
  c.raw(packed);
  const std::string chunk = record(Opcode::chunk, c.bytes());

  const std::uint64_t chunk_at = bytes_;
  files::ByteWriter offsets;
  std::string indexes;
  for (const auto& [channel, places] : index_) {
    files::ByteWriter entries, content;
    for (const auto& [time, place] : places) {
      entries.number(time);
      entries.number(place);
    }
    content.number(channel);
    put_array(content, entries);
    offsets.number(channel);
    offsets.number(chunk_at + chunk.size() + indexes.size());
    indexes += record(Opcode::message_index, content.bytes());
  }
  files::ByteWriter index;
  index.number(chunk_first_);
  index.number(chunk_last_);
  index.number(chunk_at);
  index.number(static_cast<std::uint64_t>(chunk.size()));
  put_array(index, offsets);
  index.number(static_cast<std::uint64_t>(indexes.size()));
  index.string(kPacking);
  index.number(static_cast<std::uint64_t>(packed.size()));
  index.number(static_cast<std::uint64_t>(chunk_.size()));
  chunk_indexes_ += record(Opcode::chunk_index, index.bytes());
  ++chunks_;
  chunk_.clear();
  index_.clear();
  put(chunk + indexes);
}

std::string Writer::statistics() const {
  files::ByteWriter s, counts;
  for (const auto& [id, n] : count_) {
    counts.number(id);
    counts.number(n);
  }
  s.number(messages_);
  s.number(static_cast<std::uint16_t>(schema_ids_.size()));
  s.number(static_cast<std::uint32_t>(count_.size()));
  s.number(std::uint32_t{0});  // attachments
  s.number(metadata_);
  s.number(chunks_);
  s.number(first_);
  s.number(last_);
  put_array(s, counts);
  return record(Opcode::statistics, s.bytes());
}

void Writer::finish() {
  close_chunk();
  files::ByteWriter end;
  end.number(data_crc_);
  put(record(Opcode::data_end, end.bytes()));
  const std::uint64_t summary_at = bytes_;
  files::ByteWriter offsets;  // of the groups of the summary
  std::string summary;
  const auto group = [&](Opcode opcode, const std::string& records) {
    if (records.empty()) return;
    files::ByteWriter o;
    o.number(static_cast<std::uint8_t>(opcode));
    o.number(summary_at + summary.size());
    o.number(static_cast<std::uint64_t>(records.size()));
    offsets.raw(record(Opcode::summary_offset, o.bytes()));
    summary += records;
  };
  group(Opcode::schema, schemas_);
  group(Opcode::channel, channels_);
  group(Opcode::statistics, statistics());
  group(Opcode::chunk_index, chunk_indexes_);
  group(Opcode::metadata_index, metadata_indexes_);
  files::ByteWriter footer;
  footer.number(static_cast<std::uint8_t>(Opcode::footer));
  footer.number(std::uint64_t{20});
  footer.number(summary_at);
  footer.number(summary_at + summary.size());
  summary += offsets.bytes() + footer.bytes();
  files::ByteWriter crc;  // of the summary and the footer up to here
  crc.number(crc32(bytes_of(summary)));
  put(summary + crc.bytes() + std::string(kMagic));
}

}  // namespace sanso::mcap
