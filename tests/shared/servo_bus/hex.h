// Bytes written as in the manual: "FF FF FD 00 ...".
#pragma once

#include <cstdint>
#include <cstdio>
#include <span>
#include <sstream>
#include <string>
#include <vector>

namespace sanso::servo_bus {

inline std::vector<std::uint8_t> bytes(const std::string& hex) {
  std::vector<std::uint8_t> out;
  std::istringstream in(hex);
  for (unsigned value; in >> std::hex >> value;) out.push_back(static_cast<std::uint8_t>(value));
  return out;
}

inline std::string hex(std::span<const std::uint8_t> data) {
  std::string out;
  for (const std::uint8_t byte : data) {
    char text[4];
    std::snprintf(text, sizeof text, "%02X ", byte);
    out += text;
  }
  if (!out.empty()) out.pop_back();
  return out;
}

}  // namespace sanso::servo_bus
