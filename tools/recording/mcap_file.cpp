// Parses front to back, unpacks and checks chunks, stops where the file was cut, and refuses by
// name what is damaged or unknown.
#include "tools/recording/mcap_file.h"

#include <lz4frame.h>
#include <zstd.h>

#include <fstream>
#include <map>

#include "shared/base/crc32.h"
#include "shared/files/bytes.h"
#include "shared/files/input_error.h"
#include "shared/mcap/opcodes.h"

namespace sanso::recording {
namespace {

using mcap::Opcode;

constexpr std::uint64_t kMaxRecord = 256u << 20;  // bytes; larger chunks are no recording of joints

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

class Parser {
 public:
  Parser(std::string path,
         const std::function<void(const McapChannel&, std::uint64_t, std::string_view)>& on_message)
      : path_(std::move(path)), on_message_(on_message) {}

  /// False at the end of the data section.
  bool record(std::uint8_t opcode, std::string_view content, bool inside_chunk) {
    files::ByteReader in(content);
    switch (Opcode{opcode}) {
      case Opcode::schema:
        schema(in);
        break;
      case Opcode::channel:
        channel(in);
        break;
      case Opcode::message:
        message(in, content);
        break;
      case Opcode::chunk:
        if (!inside_chunk) chunk(in);
        break;
      case Opcode::data_end:
      case Opcode::footer:
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
    const auto checksum = in.number<std::uint32_t>();  // 0: the writer did without
    const std::string_view compression = in.string();
    const std::string_view packed = in.take(in.number<std::uint64_t>());
    if (!in.ok()) damaged();
    if (size > kMaxRecord)
      throw files::InputError(path_, 0, "", "chunk too large", std::to_string(size),
                              "at most 256 MB");
    const std::string records = unpack(packed, compression, size, path_);
    if (checksum != 0 &&
        checksum != crc32({reinterpret_cast<const std::uint8_t*>(records.data()), records.size()}))
      throw files::InputError(path_, 0, "", "damaged chunk", "checksum does not fit",
                              "an intact file");
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

}  // namespace

bool read_mcap_messages(
    const std::string& path,
    const std::function<void(const McapChannel&, std::uint64_t, std::string_view)>& on_message) {
  std::ifstream in(path, std::ios::binary);
  char magic[8] = {};
  if (!in || !in.read(magic, 8) || std::string_view(magic, 8) != mcap::kMagic) {
    throw files::InputError(path, 0, "", "not an MCAP file", "",
                            "a file that starts with the MCAP magic bytes");
  }
  Parser parser(path, on_message);
  std::string content;
  for (;;) {
    char head[9];
    if (!in.read(head, 9)) return false;
    files::ByteReader reader(std::string_view(head, 9));
    const auto opcode = reader.number<std::uint8_t>();
    const auto length = reader.number<std::uint64_t>();
    if (opcode == 0) return false;  // zeros: what a file system may leave after a power cut
    if (length > kMaxRecord)
      throw files::InputError(path, 0, "", "record too large", std::to_string(length),
                              "at most 256 MB");
    content.resize(length);
    if (!in.read(content.data(), static_cast<std::streamsize>(length))) return false;
    if (!parser.record(opcode, content, false)) return true;
  }
}

}  // namespace sanso::recording
