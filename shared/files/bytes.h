// Bounds-checked little-endian reading and writing of byte strings on the heap: the ground under
// CDR, MCAP and framed files. The wire has its own without heap, shared/base/byte_io.h.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

namespace sanso::files {

static_assert(std::endian::native == std::endian::little,
              "files are little-endian and read by copying");

/// Reads from a byte string; past the end every read fails and `ok()` stays false.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}
  bool ok() const { return ok_; }
  bool done() const { return at_ >= bytes_.size(); }
  std::size_t position() const { return at_; }
  std::size_t left() const { return bytes_.size() - at_; }

  template <class T>
  T number() {
    T value{};
    const std::string_view raw = take(sizeof(T));
    if (ok_) std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }
  std::string_view take(std::size_t count) {
    if (!ok_ || count > left()) {
      ok_ = false;
      return {};
    }
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }
  /// Length as u32, then as many bytes.
  std::string_view string() { return take(number<std::uint32_t>()); }
  void align(std::size_t to) { take((to - at_ % to) % to); }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

class ByteWriter {
 public:
  template <class T>
  void number(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void raw(std::string_view bytes) { bytes_.append(bytes); }
  void string(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    raw(text);
  }
  void align(std::size_t to) { bytes_.append((to - bytes_.size() % to) % to, '\0'); }
  std::size_t size() const { return bytes_.size(); }
  const std::string& bytes() const { return bytes_; }
  std::span<const std::uint8_t> span() const {
    return {reinterpret_cast<const std::uint8_t*>(bytes_.data()), bytes_.size()};
  }

 private:
  std::string bytes_;
};

}  // namespace sanso::files
