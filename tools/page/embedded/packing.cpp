// zlib does the packing; base64 is RFC 4648 with padding. The page's reader is unpack() of
// tools/page/web/src/unpack.js.
#include "tools/page/embedded/packing.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace sanso::page {
namespace {

constexpr double kSteps = 65535.0, kMiddle = 32768.0;

}  // namespace

std::string gzip(std::string_view bytes) {
  constexpr int kWindowBits = 15, kGzipHeader = 16, kMemory = 8;
  z_stream z{};
  if (deflateInit2(&z, Z_BEST_COMPRESSION, Z_DEFLATED, kWindowBits + kGzipHeader, kMemory,
                   Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("zlib: no memory to pack");
  std::string out(deflateBound(&z, bytes.size()), '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  z.avail_in = static_cast<uInt>(bytes.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  const int ended = deflate(&z, Z_FINISH);
  out.resize(z.total_out);
  deflateEnd(&z);
  if (ended != Z_STREAM_END) throw std::runtime_error("zlib: the bytes could not be packed");
  return out;
}

std::string base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned block = 0;
    for (std::size_t k = 0; k < 3; ++k)
      block = block << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k <= bytes.size() ? kDigits[block >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

void PackedRuns::add(const std::string& about, std::span<const double> numbers) {
  const std::size_t count = numbers.size() / columns_;
  nlohmann::json lows = nlohmann::json::array(), steps = nlohmann::json::array();
  for (std::size_t c = 0; c < columns_; ++c) {
    double low = count > 0 ? numbers[c] : 0.0, high = low;
    for (std::size_t k = 1; k < count; ++k) {
      low = std::min(low, numbers[k * columns_ + c]);
      high = std::max(high, numbers[k * columns_ + c]);
    }
    const double step = high > low ? (high - low) / kSteps : 1.0;
    lows.push_back(low);
    steps.push_back(step);
    std::int32_t before = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const auto value = static_cast<std::int32_t>(
          std::lround((numbers[k * columns_ + c] - low) / step - kMiddle));
      words_.push_back(static_cast<std::int16_t>(static_cast<std::uint32_t>(value - before)));
      before = value;
    }
  }
  nlohmann::json run = nlohmann::json::parse(about);
  run["count"] = count;
  run["low"] = lows;
  run["step"] = steps;
  runs_.push_back(run.dump());
}

std::string PackedRuns::pack(const std::string& head) const {
  nlohmann::json whole = nlohmann::json::parse(head);
  whole["columns"] = std::vector<int>(columns_);
  whole["trials"] = nlohmann::json::array();
  for (const std::string& run : runs_) whole["trials"].push_back(nlohmann::json::parse(run));
  const std::string text = whole.dump();
  const auto size = static_cast<std::uint32_t>(text.size());
  std::string out(reinterpret_cast<const char*>(&size), sizeof size);
  out += text;
  out.append(reinterpret_cast<const char*>(words_.data()), 2 * words_.size());
  return out;
}

}  // namespace sanso::page
