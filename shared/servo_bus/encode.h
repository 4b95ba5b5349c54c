// Packets to bytes. Every function replaces the contents of `out`; Status::full means that the
// packet does not fit and `out` is empty, Status::out_of_range that an id or length cannot be sent.
#pragma once

#include <cstdint>
#include <span>

#include "shared/base/status.h"
#include "shared/servo_bus/packet.h"

namespace sanso::servo_bus {

/// Any instruction with raw parameters; adds header, byte stuffing, length and CRC.
Status encode(PacketBuffer& out, std::uint8_t id, Instruction instruction,
              std::span<const std::uint8_t> parameters);

Status encode_ping(PacketBuffer& out, std::uint8_t id);
Status encode_reboot(PacketBuffer& out, std::uint8_t id);
Status encode_read(PacketBuffer& out, std::uint8_t id, std::uint16_t address, std::uint16_t length);
Status encode_write(PacketBuffer& out, std::uint8_t id, std::uint16_t address,
                    std::span<const std::uint8_t> data);

/// One address and length, several ids; replies come in the order of `ids` (fast: merged into one
/// packet).
Status encode_sync_read(PacketBuffer& out, std::uint16_t address, std::uint16_t length,
                        std::span<const std::uint8_t> ids);
Status encode_fast_sync_read(PacketBuffer& out, std::uint16_t address, std::uint16_t length,
                             std::span<const std::uint8_t> ids);

/// `data` holds ids.size() blocks of `length` bytes, in the order of `ids`.
Status encode_sync_write(PacketBuffer& out, std::uint16_t address, std::uint16_t length,
                         std::span<const std::uint8_t> ids, std::span<const std::uint8_t> data);

/// A device's answer: error byte (with alert bit) and data.
Status encode_status(PacketBuffer& out, std::uint8_t id, std::uint8_t error,
                     std::span<const std::uint8_t> data);

/// The merged answer to a fast read, device by device. Not stuffed; every block ends with the CRC
/// of all bytes so far.
class FastStatusWriter {
 public:
  /// `length_field` is 1 + sum over devices of (data length + 4).
  Status begin(PacketBuffer& out, std::size_t length_field);
  Status append(PacketBuffer& out, std::uint8_t id, std::uint8_t error,
                std::span<const std::uint8_t> data);

 private:
  std::uint16_t crc_ = 0;
};

}  // namespace sanso::servo_bus
