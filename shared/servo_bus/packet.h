// What a Protocol 2.0 packet is: codes, sizes, and a packet as a plain value. Making bytes:
// encode.h; reading:
// parser.h. Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0".
#pragma once

#include <cstdint>
#include <span>

#include "shared/base/fixed_vector.h"

namespace sanso::servo_bus {

inline constexpr std::uint8_t kBroadcastId = 0xFE;
inline constexpr std::uint8_t kMaxId = 252;  // 253 and 255 would look like a header

// FF FF FD 00 | id | length low, high | instruction | parameters | CRC low, high
inline constexpr std::size_t kHeaderBytes = 7;  // up to and including the length
inline constexpr std::size_t kInstructionOffset = 7;
inline constexpr std::size_t kMinPacketBytes = 10;  // no parameters
// largest in use: fast reply of 20 servos x 21 bytes = 508
inline constexpr std::size_t kMaxPacketBytes = 1024;
inline constexpr std::size_t kMaxParameters = kMaxPacketBytes - kMinPacketBytes;

using PacketBuffer = FixedVector<std::uint8_t, kMaxPacketBytes>;

enum class Instruction : std::uint8_t {
  ping = 0x01,
  read = 0x02,
  write = 0x03,
  reg_write = 0x04,
  action = 0x05,
  factory_reset = 0x06,
  reboot = 0x08,
  clear = 0x10,
  status = 0x55,
  sync_read = 0x82,
  sync_write = 0x83,
  fast_sync_read = 0x8A,
  bulk_read = 0x92,
  bulk_write = 0x93,
  fast_bulk_read = 0x9A,
};

/// Low seven bits of a status packet's error byte.
enum class StatusError : std::uint8_t {
  none = 0,
  result_fail = 1,
  unknown_instruction = 2,
  crc_mismatch = 3,
  data_range = 4,
  data_length = 5,
  data_limit = 6,
  access = 7,
};

/// Top bit of the error byte: Hardware Error Status (register 70) is not zero.
inline constexpr std::uint8_t kAlertBit = 0x80;

/// One packet, parameters without stuffing. In a status packet the error byte is split off into
/// `error`.
struct Packet {
  std::uint8_t id = 0;
  Instruction instruction = Instruction::ping;
  std::uint8_t error = 0;  // status packets only, with alert bit
  FixedVector<std::uint8_t, kMaxParameters> parameters;

  bool is_status() const { return instruction == Instruction::status; }
  bool alert() const { return (error & kAlertBit) != 0; }
  StatusError status_error() const { return static_cast<StatusError>(error & 0x7f); }
};

/// A packet's wire time at 8N1: ten bit times a byte.
constexpr std::int64_t wire_time_ns(std::size_t bytes, std::int64_t baud) {
  return static_cast<std::int64_t>(bytes) * 10 * 1'000'000'000 / baud;
}

// Little-endian fields.
constexpr std::uint16_t get_u16(std::span<const std::uint8_t> b) {
  return static_cast<std::uint16_t>(b[0] | (b[1] << 8));
}
constexpr std::int16_t get_i16(std::span<const std::uint8_t> b) {
  return static_cast<std::int16_t>(get_u16(b));
}
constexpr std::uint32_t get_u32(std::span<const std::uint8_t> b) {
  return static_cast<std::uint32_t>(b[0]) | (static_cast<std::uint32_t>(b[1]) << 8) |
         (static_cast<std::uint32_t>(b[2]) << 16) | (static_cast<std::uint32_t>(b[3]) << 24);
}
constexpr std::int32_t get_i32(std::span<const std::uint8_t> b) {
  return static_cast<std::int32_t>(get_u32(b));
}

/// Writes the low `size` bytes of `value` (two's complement) to `out`.
constexpr void put_le(std::uint8_t* out, std::size_t size, std::int64_t value) {
  for (std::size_t i = 0; i < size; ++i) {
    out[i] = static_cast<std::uint8_t>((static_cast<std::uint64_t>(value) >> (8 * i)) & 0xff);
  }
}

}  // namespace sanso::servo_bus
