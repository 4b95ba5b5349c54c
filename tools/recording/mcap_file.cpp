// Parses front to back, unpacks chunks, and refuses by name what is cut or unknown.
#include "tools/recording/mcap_file.h"

#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <fstream>

#include "shared/files/atomic_file.h"
#include "shared/files/bytes.h"
#include "shared/files/input_error.h"

namespace sanso::recording {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::uint64_t kMaxRecord = 256u << 20;  // bytes; larger chunks are no recording of joints
constexpr std::size_t kChunkBytes = 1u << 20;
enum Opcode : std::uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kChunkIndex = 8,
  kStatistics = 11,
  kDataEnd = 15
};

std::string unpack(std::string_view packed, std::string_view compression, std::uint64_t size,
                   const std::string& path) {
  if (compression.empty()) return std::string(packed);
  std::string out(size, '\0');
  bool good = false;
  if (compression == "zstd") {
    const std::size_t got = ZSTD_decompress(out.data(), out.size(), packed.data(), packed.size());
    good = !ZSTD_isError(got) && got == out.size();
  } else if (compression == "lz4") {
    LZ4F_dctx* context = nullptr;
    if (!LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) {
      std::size_t produced = 0, consumed = 0;
      for (std::size_t hint = 1; hint != 0 && consumed < packed.size();) {
        std::size_t room = out.size() - produced, taken = packed.size() - consumed;
        hint = LZ4F_decompress(context, out.data() + produced, &room, packed.data() + consumed,
                               &taken, nullptr);
        if (LZ4F_isError(hint) || (room == 0 && taken == 0)) break;
        produced += room;
        consumed += taken;
      }
      good = produced == out.size();
      LZ4F_freeDecompressionContext(context);
    }
  } else {
    throw files::InputError(path, 0, "", "unknown compression", std::string(compression),
                            "none, lz4 or zstd");
  }
  if (!good)
    throw files::InputError(path, 0, "", "damaged chunk", std::string(compression),
                            "an intact file");
  return out;
}

class McapParser {
 public:
  McapParser(
      std::string path,
      const std::function<void(const McapChannel&, std::uint64_t, std::string_view)>& on_message)
      : path_(std::move(path)), on_message_(on_message) {}

  /// False at the end of the data section.
  bool record(std::uint8_t opcode, std::string_view content, bool inside_chunk) {
    files::ByteReader in(content);
    switch (opcode) {
      case kSchema:
        schema(in);
        break;
      case kChannel:
        channel(in);
        break;
      case kMessage:
        message(in, content);
        break;
      case kChunk:
        if (!inside_chunk) chunk(in);
        break;
      case kDataEnd:
      case kFooter:
        return false;
      default:
        break;  // indexes, attachments, metadata: not needed
    }
    if (!in.ok()) damaged();
    return true;
  }

 private:
  [[noreturn]] void damaged() const {
    throw files::InputError(path_, 0, "", "damaged MCAP record", "", "an intact file");
  }

  void schema(files::ByteReader& in) {
    const auto id = in.number<std::uint16_t>();
    schemas_[id] = std::string(in.string());
  }
  void channel(files::ByteReader& in) {
    const auto id = in.number<std::uint16_t>();
    const auto schema = in.number<std::uint16_t>();
    McapChannel c;
    c.topic = std::string(in.string());
    c.encoding = std::string(in.string());
    c.schema = schemas_[schema];
    channels_[id] = std::move(c);
  }
  void message(files::ByteReader& in, std::string_view content) {
    const auto id = in.number<std::uint16_t>();
    in.number<std::uint32_t>();  // sequence
    const auto log_time = in.number<std::uint64_t>();
    in.number<std::uint64_t>();  // publish time
    const auto c = channels_.find(id);
    if (!in.ok() || c == channels_.end()) damaged();
    on_message_(c->second, log_time, content.substr(in.position()));
  }
  void chunk(files::ByteReader& in) {
    in.number<std::uint64_t>();  // first and last time
    in.number<std::uint64_t>();
    const auto size = in.number<std::uint64_t>();
    in.number<std::uint32_t>();  // checksum, optional in the format
    const std::string_view compression = in.string();
    const std::string_view packed = in.take(in.number<std::uint64_t>());
    if (!in.ok()) damaged();
    if (size > kMaxRecord)
      throw files::InputError(path_, 0, "", "chunk too large", std::to_string(size),
                              "at most 256 MB");
    const std::string records = unpack(packed, compression, size, path_);
    files::ByteReader inner(records);
    while (!inner.done()) {
      const auto opcode = inner.number<std::uint8_t>();
      const std::string_view content = inner.take(inner.number<std::uint64_t>());
      if (!inner.ok()) damaged();
      record(opcode, content, true);
    }
  }

  std::string path_;
  const std::function<void(const McapChannel&, std::uint64_t, std::string_view)>& on_message_;
  std::map<std::uint16_t, std::string> schemas_;
  std::map<std::uint16_t, McapChannel> channels_;
};

std::string record_bytes(std::uint8_t opcode, const std::string& content) {
  files::ByteWriter out;
  out.number(opcode);
  out.number(static_cast<std::uint64_t>(content.size()));
  out.raw(content);
  return out.bytes();
}

}  // namespace

void read_mcap_messages(
    const std::string& path,
    const std::function<void(const McapChannel&, std::uint64_t, std::string_view)>& on_message) {
  std::ifstream in(path, std::ios::binary);
  char magic[8] = {};
  if (!in || !in.read(magic, 8) || std::string_view(magic, 8) != kMagic) {
    throw files::InputError(path, 0, "", "not an MCAP file", "",
                            "a file that starts with the MCAP magic bytes");
  }
  McapParser parser(path, on_message);
  std::string content;
  for (;;) {
    char head[9];
    if (!in.read(head, 9))
      throw files::InputError(path, 0, "", "truncated MCAP file", "",
                              "a file that was closed properly");
    files::ByteReader reader(std::string_view(head, 9));
    const auto opcode = reader.number<std::uint8_t>();
    const auto length = reader.number<std::uint64_t>();
    if (length > kMaxRecord)
      throw files::InputError(path, 0, "", "record too large", std::to_string(length),
                              "at most 256 MB");
    content.resize(length);
    if (!in.read(content.data(), static_cast<std::streamsize>(length))) {
      throw files::InputError(path, 0, "", "truncated MCAP file", "",
                              "a file that was closed properly");
    }
    if (!parser.record(opcode, content, false)) return;
  }
}

McapWriter::McapWriter(std::string path) : path_(std::move(path)), file_(kMagic) {
  files::ByteWriter header;
  header.string("ros2");
  header.string("sanso");
  file_ += record_bytes(kHeader, header.bytes());
}

std::uint16_t McapWriter::add_channel(const std::string& topic, const std::string& schema,
                                      std::string_view definition) {
  const auto id = static_cast<std::uint16_t>(count_.size() + 1);
  files::ByteWriter s;
  s.number(id);
  s.string(schema);
  s.string("ros2msg");
  s.string(definition);
  files::ByteWriter c;
  c.number(id);
  c.number(id);
  c.string(topic);
  c.string("cdr");
  c.number(std::uint32_t{0});  // no metadata
  const std::string records = record_bytes(kSchema, s.bytes()) + record_bytes(kChannel, c.bytes());
  declarations_ += records;
  chunk_ += records;
  count_[id] = 0;
  return id;
}

void McapWriter::write(std::uint16_t channel, std::uint64_t time_ns, std::string_view cdr) {
  files::ByteWriter m;
  m.number(channel);
  m.number(static_cast<std::uint32_t>(count_[channel]++));
  m.number(time_ns);
  m.number(time_ns);
  m.raw(cdr);
  if (messages_ == 0 || chunk_start_ == 0) chunk_start_ = time_ns;
  chunk_end_ = std::max(chunk_end_, time_ns);
  first_ = std::min(first_, time_ns);
  last_ = std::max(last_, time_ns);
  ++messages_;
  chunk_ += record_bytes(kMessage, m.bytes());
  if (chunk_.size() > kChunkBytes) close_chunk();
}

void McapWriter::close_chunk() {
  if (chunk_.empty()) return;
  std::string packed(ZSTD_compressBound(chunk_.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), chunk_.data(), chunk_.size(), 3));
  files::ByteWriter c;
  c.number(chunk_start_);
  c.number(chunk_end_);
  c.number(static_cast<std::uint64_t>(chunk_.size()));
  c.number(std::uint32_t{0});  // no checksum
  c.string("zstd");
  c.number(static_cast<std::uint64_t>(packed.size()));
  c.raw(packed);
  const std::string bytes = record_bytes(kChunk, c.bytes());
  files::ByteWriter index;
  index.number(chunk_start_);
  index.number(chunk_end_);
  index.number(static_cast<std::uint64_t>(file_.size()));
  index.number(static_cast<std::uint64_t>(bytes.size()));
  index.number(std::uint32_t{0});  // no message index
  index.number(std::uint64_t{0});
  index.string("zstd");
  index.number(static_cast<std::uint64_t>(packed.size()));
  index.number(static_cast<std::uint64_t>(chunk_.size()));
  chunk_indexes_ += record_bytes(kChunkIndex, index.bytes());
  file_ += bytes;
  chunk_.clear();
  chunk_start_ = chunk_end_ = 0;
  ++chunks_;
}

void McapWriter::finish() {
  close_chunk();
  files::ByteWriter end;
  end.number(std::uint32_t{0});
  file_ += record_bytes(kDataEnd, end.bytes());
  const std::uint64_t summary = file_.size();
  files::ByteWriter s;
  s.number(messages_);
  s.number(static_cast<std::uint16_t>(count_.size()));
  s.number(static_cast<std::uint32_t>(count_.size()));
  s.number(std::uint32_t{0});  // attachments
  s.number(std::uint32_t{0});  // metadata
  s.number(chunks_);
  s.number(messages_ == 0 ? std::uint64_t{0} : first_);
  s.number(last_);
  s.number(static_cast<std::uint32_t>(count_.size() * 10));
  for (const auto& [id, n] : count_) {
    s.number(id);
    s.number(n);
  }
  file_ += declarations_ + record_bytes(kStatistics, s.bytes()) + chunk_indexes_;
  files::ByteWriter footer;
  footer.number(summary);
  footer.number(std::uint64_t{0});
  footer.number(std::uint32_t{0});
  file_ += record_bytes(kFooter, footer.bytes());
  file_ += kMagic;
  files::write_atomically(path_, file_);
}

}  // namespace sanso::recording
