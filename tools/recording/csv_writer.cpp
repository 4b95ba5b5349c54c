// Shortest decimal that reads back to the same bits; an empty cell for "not sampled".
#include "tools/recording/csv_writer.h"

#include <zlib.h>

#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "shared/files/input_error.h"
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
  const std::string temporary = path + ".part";
  const std::string text = to_csv(recording);
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(
      gzopen(temporary.c_str(), packed ? "wb6" : "wbT"), gzclose);
  bool good = file != nullptr;
  for (std::size_t done = 0; good && done < text.size();) {
    const auto chunk = static_cast<unsigned>(std::min<std::size_t>(text.size() - done, 1u << 24));
    good = gzwrite(file.get(), text.data() + done, chunk) == static_cast<int>(chunk);
    done += chunk;
  }
  good = good && gzflush(file.get(), Z_FINISH) == Z_OK;
  std::error_code error;
  if (good) std::filesystem::rename(temporary, path, error);
  if (!good || error)
    throw files::InputError(path, 0, "", "cannot write", "", "a writable folder with free space");

  if (!recording.condition.empty() || !recording.overrides.empty() || !recording.payloads.empty()) {
    std::filesystem::path sidecar = path;
    if (packed) sidecar.replace_extension();
    write_sidecar(recording, sidecar.replace_extension(".toml").string());
  }
}

}  // namespace sanso::recording
