// Shortest decimal that reads back to the same bits; an empty cell for "not sampled".
#include "tools/recording/csv_writer.h"

#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <new>
#include <stdexcept>

#include "shared/files/atomic_file.h"
#include "tools/recording/sidecar.h"

namespace sanso::recording {
namespace {

/// Shortest text that reads back to the same number; nothing for NaN.
void append_number(std::string& out, double value) {
  if (std::isnan(value)) return;
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  out.append(buffer, end);
}

/// The bytes that gzopen(path, "wb6") would write.
std::string gzipped(const std::string& text) {
  z_stream stream{};
  constexpr int kGzip = 16;  // added to the window bits: gzip instead of zlib framing
  if (deflateInit2(&stream, 6, Z_DEFLATED, MAX_WBITS + kGzip, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  std::string out(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  std::size_t left = text.size(), room = out.size();
  int state = Z_OK;
  while (state == Z_OK) {  // the library counts in 32 bits
    stream.avail_in = static_cast<uInt>(std::min<std::size_t>(left, 1u << 30));
    stream.avail_out = static_cast<uInt>(std::min<std::size_t>(room, 1u << 30));
    const std::size_t in_before = stream.avail_in, out_before = stream.avail_out;
    state = deflate(&stream, left > stream.avail_in ? Z_NO_FLUSH : Z_FINISH);
    left -= in_before - stream.avail_in;
    room -= out_before - stream.avail_out;
  }
  out.resize(out.size() - room);
  deflateEnd(&stream);
  if (state != Z_STREAM_END) throw std::logic_error("zlib did not finish a text in memory");
  return out;
}

}  // namespace

std::string to_csv(const Recording& recording) {
  std::string out = "t";
  for (const Channel& channel : recording.channels) out += "," + channel.name;
  out += '\n';
  for (std::size_t k = 0; k < recording.rows(); ++k) {
    append_number(out, recording.t[k]);
    for (const Channel& channel : recording.channels) {
      out += ',';
      append_number(out, channel.values[k]);
    }
    out += '\n';
  }
  return out;
}

void write_csv(const Recording& recording, const std::string& path) {
  const bool packed = path.size() > 3 && path.ends_with(".gz");
  const std::string text = to_csv(recording);
  files::write_atomically(path, packed ? gzipped(text) : text);

  if (!recording.condition.empty() || !recording.overrides.empty() || !recording.payloads.empty()) {
    std::filesystem::path sidecar = path;
    if (packed) sidecar.replace_extension();
    write_sidecar(recording, sidecar.replace_extension(".toml").string());
  }
}

}  // namespace sanso::recording
