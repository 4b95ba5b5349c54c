// Every packet is header, id, length, stuffed body and CRC; whatever does not fit leaves `out`
// empty.
#include "shared/servo_bus/encode.h"

#include "shared/servo_bus/crc16.h"

namespace sanso::servo_bus {
namespace {

/// Appends bytes with stuffing: after every FF FF FD one more FD, so that no header can appear
/// inside a packet.
class StuffedWriter {
 public:
  explicit StuffedWriter(PacketBuffer& out) : out_(out) {}

  void put(std::uint8_t byte) {
    ok_ = ok_ && out_.try_push(byte);
    if (matched_ == 2 && byte == 0xFD) {
      ok_ = ok_ && out_.try_push(0xFD);
      matched_ = 0;
    } else if (byte == 0xFF) {
      matched_ = matched_ < 2 ? matched_ + 1 : 2;
    } else {
      matched_ = 0;
    }
  }
  void put_u16(std::uint16_t value) {
    put(static_cast<std::uint8_t>(value & 0xff));
    put(static_cast<std::uint8_t>(value >> 8));
  }
  void put(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) put(byte);
  }
  bool ok() const { return ok_; }

 private:
  PacketBuffer& out_;
  int matched_ = 0;  // how many bytes of FF FF precede
  bool ok_ = true;
};

bool valid_id(std::uint8_t id) { return id <= kMaxId || id == kBroadcastId; }

Status begin(PacketBuffer& out, std::uint8_t id) {
  out.clear();
  if (!valid_id(id)) return Status::out_of_range;
  const std::uint8_t header[kHeaderBytes] = {0xFF, 0xFF, 0xFD, 0x00, id, 0, 0};
  return out.try_append(header) ? Status::ok : Status::full;
}

bool append_crc(PacketBuffer& out) {
  const std::uint16_t crc = crc16(out.view());
  return out.try_push(static_cast<std::uint8_t>(crc & 0xff)) &&
         out.try_push(static_cast<std::uint8_t>(crc >> 8));
}

Status finish(PacketBuffer& out, bool ok) {
  const std::size_t length = out.size() - kHeaderBytes + 2;
  if (ok) {
    out[5] = static_cast<std::uint8_t>(length & 0xff);
    out[6] = static_cast<std::uint8_t>(length >> 8);
    ok = append_crc(out);
  }
  if (ok) return Status::ok;
  out.clear();
  return Status::full;
}

/// Frame around whatever `body` writes: header, instruction, body, length, CRC.
template <class Body>
Status frame(PacketBuffer& out, std::uint8_t id, Instruction instruction, Body&& body) {
  const Status begun = begin(out, id);
  if (begun != Status::ok) return begun;
  StuffedWriter writer(out);
  writer.put(static_cast<std::uint8_t>(instruction));
  body(writer);
  return finish(out, writer.ok());
}

Status sync_request(PacketBuffer& out, Instruction instruction, std::uint16_t address,
                    std::uint16_t length, std::span<const std::uint8_t> ids) {
  return frame(out, kBroadcastId, instruction, [&](StuffedWriter& w) {
    w.put_u16(address);
    w.put_u16(length);
    w.put(ids);
  });
}

}  // namespace

Status encode(PacketBuffer& out, std::uint8_t id, Instruction instruction,
              std::span<const std::uint8_t> parameters) {
  return frame(out, id, instruction, [&](StuffedWriter& w) { w.put(parameters); });
}

Status encode_ping(PacketBuffer& out, std::uint8_t id) {
  return encode(out, id, Instruction::ping, {});
}
Status encode_reboot(PacketBuffer& out, std::uint8_t id) {
  return encode(out, id, Instruction::reboot, {});
}

Status encode_read(PacketBuffer& out, std::uint8_t id, std::uint16_t address,
                   std::uint16_t length) {
  return frame(out, id, Instruction::read, [&](StuffedWriter& w) {
    w.put_u16(address);
    w.put_u16(length);
  });
}

Status encode_write(PacketBuffer& out, std::uint8_t id, std::uint16_t address,
                    std::span<const std::uint8_t> data) {
  return frame(out, id, Instruction::write, [&](StuffedWriter& w) {
    w.put_u16(address);
    w.put(data);
  });
}

Status encode_sync_read(PacketBuffer& out, std::uint16_t address, std::uint16_t length,
                        std::span<const std::uint8_t> ids) {
  return sync_request(out, Instruction::sync_read, address, length, ids);
}

Status encode_fast_sync_read(PacketBuffer& out, std::uint16_t address, std::uint16_t length,
                             std::span<const std::uint8_t> ids) {
  return sync_request(out, Instruction::fast_sync_read, address, length, ids);
}

Status encode_sync_write(PacketBuffer& out, std::uint16_t address, std::uint16_t length,
                         std::span<const std::uint8_t> ids, std::span<const std::uint8_t> data) {
  out.clear();
  if (data.size() != ids.size() * length) return Status::out_of_range;
  return frame(out, kBroadcastId, Instruction::sync_write, [&](StuffedWriter& w) {
    w.put_u16(address);
    w.put_u16(length);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      w.put(ids[i]);
      w.put(data.subspan(i * length, length));
    }
  });
}

Status encode_status(PacketBuffer& out, std::uint8_t id, std::uint8_t error,
                     std::span<const std::uint8_t> data) {
  return frame(out, id, Instruction::status, [&](StuffedWriter& w) {
    w.put(error);
    w.put(data);
  });
}

Status FastStatusWriter::begin(PacketBuffer& out, std::size_t length_field) {
  out.clear();
  if (length_field > 0xffff) return Status::out_of_range;
  const std::uint8_t head[] = {0xFF,
                               0xFF,
                               0xFD,
                               0x00,
                               kBroadcastId,
                               static_cast<std::uint8_t>(length_field & 0xff),
                               static_cast<std::uint8_t>(length_field >> 8),
                               static_cast<std::uint8_t>(Instruction::status)};
  crc_ = crc16(head);
  return out.try_append(head) ? Status::ok : Status::full;
}

Status FastStatusWriter::append(PacketBuffer& out, std::uint8_t id, std::uint8_t error,
                                std::span<const std::uint8_t> data) {
  if (out.size() + data.size() + 4 > PacketBuffer::capacity()) return Status::full;
  const std::size_t start = out.size();
  out.try_push(error);
  out.try_push(id);
  out.try_append(data);
  const std::uint16_t crc = crc16(out.view().subspan(start), crc_);
  const std::uint8_t crc_bytes[] = {static_cast<std::uint8_t>(crc & 0xff),
                                    static_cast<std::uint8_t>(crc >> 8)};
  out.try_append(crc_bytes);
  crc_ = crc16(crc_bytes, crc);  // the next block's CRC covers this one
  return Status::ok;
}

}  // namespace sanso::servo_bus
