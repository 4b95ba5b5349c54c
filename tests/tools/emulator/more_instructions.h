// Instructions that servos understand and our controller never sends.
#pragma once

#include <initializer_list>
#include <vector>

#include "shared/servo_bus/encode.h"

namespace sanso::emulator {

/// Registers of one servo; a read has no data.
struct BulkPart {
  std::uint8_t id = 0;
  std::uint16_t address = 0, length = 0;
  std::vector<std::uint8_t> data = {};
};

inline void put_u16(std::vector<std::uint8_t>& bytes, std::uint16_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value & 0xff));
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
}

/// bulk_read, fast_bulk_read or bulk_write.
inline void encode_bulk(servo_bus::PacketBuffer& out, servo_bus::Instruction instruction,
                        std::initializer_list<BulkPart> parts) {
  std::vector<std::uint8_t> bytes;
  for (const BulkPart& part : parts) {
    bytes.push_back(part.id);
    put_u16(bytes, part.address), put_u16(bytes, part.length);
    bytes.insert(bytes.end(), part.data.begin(), part.data.end());
  }
  servo_bus::encode(out, servo_bus::kBroadcastId, instruction, bytes);
}

/// A write that waits for the action.
inline void encode_reg_write(servo_bus::PacketBuffer& out, std::uint8_t id, std::uint16_t address,
                             std::initializer_list<std::uint8_t> data) {
  std::vector<std::uint8_t> bytes;
  put_u16(bytes, address);
  bytes.insert(bytes.end(), data);
  servo_bus::encode(out, id, servo_bus::Instruction::reg_write, bytes);
}

inline void encode_action(servo_bus::PacketBuffer& out, std::uint8_t id) {
  servo_bus::encode(out, id, servo_bus::Instruction::action, {});
}

}  // namespace sanso::emulator
