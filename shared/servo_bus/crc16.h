// CRC-16 of Dynamixel Protocol 2.0: polynomial 0x8005, initial value 0, not reflected, no final xor
// (CRC-16/UMTS; "123456789" gives 0xFEE8). Not the Modbus CRC, which is reflected.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace sanso::servo_bus {

namespace detail {
constexpr std::array<std::uint16_t, 256> make_crc_table() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned i = 0; i < 256; ++i) {
    unsigned crc = i << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc << 1) ^ ((crc & 0x8000u) ? 0x8005u : 0u);
    table[i] = static_cast<std::uint16_t>(crc);
  }
  return table;
}
inline constexpr std::array<std::uint16_t, 256> kCrcTable = make_crc_table();
}  // namespace detail

/// CRC of `bytes`, continued from `crc` (0 to begin): crc16(b, crc16(a)) is the CRC of a followed
/// by b.
constexpr std::uint16_t crc16(std::span<const std::uint8_t> bytes, std::uint16_t crc = 0) {
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>((crc << 8) ^ detail::kCrcTable[((crc >> 8) ^ byte) & 0xff]);
  }
  return crc;
}

}  // namespace sanso::servo_bus
