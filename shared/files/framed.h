// Exact storage of numbers: little-endian bytes with a name, a version and a checksum around them.
// Text would round; a resumed session must continue with the same bits.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "shared/files/bytes.h"

namespace sanso::files {

template <class T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// A fixed number of values in memory order: std::array, a matrix. Stored without its size.
template <class T>
concept Values = !std::is_same_v<T, std::string> && requires(T & v) {
  v.data();
  v.size();
};

class FramedWriter {
 public:
  template <Plain T>
  void put(T value) {
    out_.number(value);
  }
  template <Values T>
  void put(const T& values) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(values.size()); ++i) put(values.data()[i]);
  }
  void put(const std::string& text) { out_.string(text); }
  std::span<const std::uint8_t> bytes() const { return out_.span(); }

 private:
  ByteWriter out_;
};

/// Reads what FramedWriter wrote, in the same order. Throws InputError when the bytes end too
/// early.
class FramedReader {
 public:
  FramedReader(std::string name, std::string bytes)
      : name_(std::move(name)), bytes_(std::move(bytes)) {}
  template <Plain T>
  void get(T& value) {
    value = read<T>();
  }
  template <Values T>
  void get(T& values) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(values.size()); ++i) get(values.data()[i]);
  }
  void get(std::string& text) { text = take(read<std::uint32_t>()); }
  template <Plain T>
  T read() {
    ByteReader in(take(sizeof(T)));
    return in.number<T>();
  }
  std::size_t left() const { return bytes_.size() - at_; }
  [[noreturn]] void fail() const;

 private:
  std::string_view take(std::size_t count);

  std::string name_;
  std::string bytes_;
  std::size_t at_ = 0;
};

/// Stores `payload` atomically as [magic (8) | version u32 | size u64 | payload | crc32 u32].
/// Throws WriteError.
void save_framed(const std::filesystem::path& path, const char (&magic)[9], std::uint32_t version,
                 std::span<const std::uint8_t> payload);

/// Opposite of save_framed. Throws InputError naming file, what was found and what was expected.
FramedReader load_framed(const std::filesystem::path& path, const char (&magic)[9],
                         std::uint32_t version);

}  // namespace sanso::files
