// Little-endian reading and writing of plain values in a caller's buffer. Both sides share one
// shape, so that a layout is written once as `archive(field)` and used to write, to read and to
// measure. No heap, no exceptions.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

namespace sanso {

namespace detail {
template <std::size_t Size>
struct UintOf;
template <>
struct UintOf<1> {
  using type = std::uint8_t;
};
template <>
struct UintOf<2> {
  using type = std::uint16_t;
};
template <>
struct UintOf<4> {
  using type = std::uint32_t;
};
template <>
struct UintOf<8> {
  using type = std::uint64_t;
};
}  // namespace detail

template <class T>
concept PlainNumber = std::is_arithmetic_v<T> && !std::is_same_v<T, bool>;

/// Appends values to a buffer; after the first one that does not fit, ok() is false and nothing
/// more is written.
class ByteWriter {
 public:
  static constexpr bool kReads = false;
  template <class T>
  using Ref = const T&;

  /// Numbers are written little-endian. `buffer` must outlive the writer.
  explicit ByteWriter(std::span<std::uint8_t> buffer) : buffer_(buffer) {}

  template <PlainNumber T>
  void operator()(const T& value) {
    using U = typename detail::UintOf<sizeof(T)>::type;
    const U bits = std::bit_cast<U>(value);
    if (!claim(sizeof(T))) return;
    for (std::size_t i = 0; i < sizeof(T); ++i)
      buffer_[size_++] = static_cast<std::uint8_t>(bits >> (8 * i));
  }
  template <class T>
  requires std::is_enum_v<T>
  void operator()(const T& value) { (*this)(static_cast<std::underlying_type_t<T>>(value)); }
  /// All of them or nothing.
  void bytes(std::span<const std::uint8_t> data) {
    if (!claim(data.size())) return;
    if (!data.empty()) std::memcpy(buffer_.data() + size_, data.data(), data.size());
    size_ += data.size();
  }

  bool ok() const { return ok_; }
  std::size_t size() const { return size_; }

 private:
  bool claim(std::size_t n) {
    if (ok_ && n > buffer_.size() - size_) ok_ = false;
    return ok_;
  }
  std::span<std::uint8_t> buffer_;
  std::size_t size_ = 0;
  bool ok_ = true;
};

/// Takes values from a buffer. Past the end, or at a number that is not finite, ok() turns false
/// for good and the values read from then on are zero.
class ByteReader {
 public:
  static constexpr bool kReads = true;
  template <class T>
  using Ref = T&;

  /// `buffer` must outlive the reader and what bytes() returns.
  explicit ByteReader(std::span<const std::uint8_t> buffer) : buffer_(buffer) {}

  template <PlainNumber T>
  void operator()(T& value) {
    using U = typename detail::UintOf<sizeof(T)>::type;
    value = T{};
    if (!claim(sizeof(T))) return;
    U bits = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
      bits = static_cast<U>(bits | (static_cast<U>(buffer_[at_++]) << (8 * i)));
    const T read = std::bit_cast<T>(bits);
    if constexpr (std::is_floating_point_v<T>) {
      if (!std::isfinite(read)) return reject();
    }
    value = read;
  }
  template <class T>
  requires std::is_enum_v<T>
  void operator()(T& value) {
    std::underlying_type_t<T> raw{};
    (*this)(raw);
    value = static_cast<T>(raw);
  }
  /// The next `n` bytes, or an empty span when there are fewer.
  std::span<const std::uint8_t> bytes(std::size_t n) {
    if (!claim(n)) return {};
    at_ += n;
    return buffer_.subspan(at_ - n, n);
  }

  /// What was read makes no sense: ok() is false from now on.
  void reject() { ok_ = false; }
  /// Requires a property of what was read.
  void require(bool condition) { ok_ = ok_ && condition; }
  bool ok() const { return ok_; }
  /// True when every byte was used and every value was good.
  bool finished() const { return ok_ && at_ == buffer_.size(); }
  std::size_t left() const { return buffer_.size() - at_; }

 private:
  bool claim(std::size_t n) {
    if (ok_ && n > left()) ok_ = false;
    return ok_;
  }
  std::span<const std::uint8_t> buffer_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace sanso
