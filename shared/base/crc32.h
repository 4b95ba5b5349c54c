// CRC-32 as in Ethernet, zlib and PNG: polynomial 0x04C11DB7 reflected, initial value and final XOR
// all ones.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace sanso {

namespace detail {
constexpr std::array<std::uint32_t, 256> make_crc32_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1u) ? 0xEDB88320u ^ (c >> 1) : c >> 1;
    table[i] = c;
  }
  return table;
}
inline constexpr std::array<std::uint32_t, 256> kCrc32Table = make_crc32_table();
}  // namespace detail

/// CRC-32 of `before` followed by `data`, where `crc` is the CRC-32 of `before` (0: nothing yet).
constexpr std::uint32_t crc32_more(std::uint32_t crc, std::span<const std::uint8_t> data) {
  std::uint32_t c = crc ^ 0xFFFFFFFFu;
  for (const std::uint8_t byte : data) c = detail::kCrc32Table[(c ^ byte) & 0xFFu] ^ (c >> 8);
  return c ^ 0xFFFFFFFFu;
}

/// CRC-32 of `data`; check value of "123456789" is 0xCBF43926.
constexpr std::uint32_t crc32(std::span<const std::uint8_t> data) { return crc32_more(0, data); }

}  // namespace sanso
