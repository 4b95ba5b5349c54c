// CDR, the encoding of ROS 2 messages: plain version 1, little-endian, aligned.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/files/bytes.h"

namespace sanso::mcap {

/// Reads past the end, or an array above kMaxCount, leave ok() false. Alignment counts from after
/// the four bytes of encapsulation.
class CdrReader {
 public:
  explicit CdrReader(std::string_view cdr)
      : in_(cdr.size() >= 4 ? cdr.substr(4) : std::string_view()) {
    good_ = cdr.size() >= 4 && cdr[0] == 0 && cdr[1] == 1;  // CDR_LE
  }
  bool ok() const { return good_ && in_.ok(); }
  template <class T>
  T number() {
    in_.align(sizeof(T));
    return in_.number<T>();
  }
  std::string string() {
    std::string_view s = in_.take(number<std::uint32_t>());
    if (!s.empty() && s.back() == '\0') s.remove_suffix(1);
    return std::string(s);
  }
  /// Length of a sequence; above kMaxCount 0, and no longer ok().
  std::uint32_t count() {
    const auto n = number<std::uint32_t>();
    if (n > kMaxCount) good_ = false;
    return good_ ? n : 0;
  }
  /// An array of any length; empty where it is too long.
  std::vector<double> doubles() {
    std::vector<double> values;
    for (std::uint32_t k = count(); k > 0 && ok(); --k) values.push_back(number<double>());
    return values;
  }
  /// Time of a message's header, s.
  double stamp() {
    const auto seconds = number<std::int32_t>();
    return seconds + 1e-9 * number<std::uint32_t>();
  }

 private:
  static constexpr std::uint32_t kMaxCount = 10'000;
  files::ByteReader in_;
  bool good_;
};

class CdrWriter {
 public:
  template <class T>
  void number(T value) {
    out_.align(sizeof(T));
    out_.number(value);
  }
  void string(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size() + 1));
    out_.raw(text);
    out_.raw(std::string_view("\0", 1));
  }
  /// An array of any length; array() is one whose length the type fixes.
  void doubles(std::span<const double> values) {
    number(static_cast<std::uint32_t>(values.size()));
    array(values);
  }
  void array(std::span<const double> values) {
    for (const double v : values) number(v);
  }
  /// std_msgs/Header.
  void header(double stamp_s, std::string_view frame_id = "") {
    const double seconds = std::floor(stamp_s);
    auto nanoseconds = static_cast<std::uint32_t>(std::lround((stamp_s - seconds) * 1e9));
    const std::uint32_t carry = nanoseconds >= 1'000'000'000u ? 1 : 0;
    number(static_cast<std::int32_t>(seconds) + static_cast<std::int32_t>(carry));
    number(nanoseconds - carry * 1'000'000'000u);
    string(frame_id);
  }
  std::string bytes() const { return std::string("\0\1\0\0", 4) + out_.bytes(); }

 private:
  files::ByteWriter out_;
};

}  // namespace sanso::mcap
