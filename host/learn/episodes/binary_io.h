// Exact storage of episodes and learned state: little-endian bytes with a name, a version and a
// checksum around them.
// Text would round; a resumed session must continue with the same bits.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

namespace sanso::learn {

template <class T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T>;

class BinaryWriter {
 public:
  template <Plain T>
  void put(T value) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
    bytes_.insert(bytes_.end(), bytes, bytes + sizeof(T));
  }
  template <class Scalar, int Rows, int Cols>
  void put(const Eigen::Matrix<Scalar, Rows, Cols>& m) {
    for (Eigen::Index i = 0; i < m.size(); ++i) put(m.data()[i]);
  }
  template <class T, std::size_t N>
  void put(const std::array<T, N>& values) {
    for (const T& v : values) put(v);
  }
  void put(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size()));
    bytes_.insert(bytes_.end(), text.begin(), text.end());
  }
  const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  std::vector<std::uint8_t> bytes_;
};

/// Reads what BinaryWriter wrote, in the same order. Throws std::runtime_error when the bytes end
/// too early.
class BinaryReader {
 public:
  BinaryReader(std::string name, std::vector<std::uint8_t> bytes)
      : name_(std::move(name)), bytes_(std::move(bytes)) {}
  template <Plain T>
  void get(T& value) {
    take(&value, sizeof(T));
  }
  template <class Scalar, int Rows, int Cols>
  void get(Eigen::Matrix<Scalar, Rows, Cols>& m) {
    for (Eigen::Index i = 0; i < m.size(); ++i) get(m.data()[i]);
  }
  template <class T, std::size_t N>
  void get(std::array<T, N>& values) {
    for (T& v : values) get(v);
  }
  void get(std::string& text) {
    const auto n = read<std::uint32_t>();
    if (n > left()) fail();
    text.assign(reinterpret_cast<const char*>(bytes_.data() + at_), n);
    at_ += n;
  }
  template <Plain T>
  T read() {
    T value{};
    get(value);
    return value;
  }
  std::size_t left() const { return bytes_.size() - at_; }
  [[noreturn]] void fail() const {
    throw std::runtime_error(name_ + ": ends at byte " + std::to_string(at_) +
                             " before it is complete; delete it and run again");
  }

 private:
  void take(void* to, std::size_t n) {
    if (n > left()) fail();
    std::memcpy(to, bytes_.data() + at_, n);
    at_ += n;
  }
  std::string name_;
  std::vector<std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

/// Stores `payload` atomically as [magic (8) | version u32 | size u64 | payload | crc32 u32].
void save_framed(const std::filesystem::path& path, const char (&magic)[9], std::uint32_t version,
                 const std::vector<std::uint8_t>& payload);

/// Opposite of save_framed. Throws std::runtime_error naming file, what was found and what was
/// expected.
BinaryReader load_framed(const std::filesystem::path& path, const char (&magic)[9],
                         std::uint32_t version);

}  // namespace sanso::learn
