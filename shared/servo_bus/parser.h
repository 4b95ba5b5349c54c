// Bytes to packets, a few bytes at a time. Survives garbage: whatever is not a packet costs one
// byte and a new search for the header; nothing that arrives makes it allocate, grow or stop.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "shared/base/status.h"
#include "shared/servo_bus/packet.h"

namespace sanso::servo_bus {

enum class ParseEvent : std::uint8_t {
  none,    // more bytes needed
  packet,  // `packet` is filled
  // a frame arrived whole but damaged; only packet.id and packet.instruction (as received) are
  // filled
  crc_error,
};

class PacketParser {
 public:
  /// Appends received bytes; returns how many fitted. Call next() until it says none, then feed the
  /// rest.
  std::size_t feed(std::span<const std::uint8_t> bytes);

  /// The next thing that the bytes fed so far hold.
  ParseEvent next(Packet& packet);

  /// Raw bytes of the packet that next() reported last; valid until the next call of feed(), next()
  /// or reset().
  std::span<const std::uint8_t> frame() const {
    return {buffer_.data() + frame_begin_, frame_size_};
  }

  /// Bytes received and not yet consumed, beginning at a possible header: at a deadline this is a
  /// reply cut short.
  std::span<const std::uint8_t> pending() const { return {buffer_.data() + begin_, end_ - begin_}; }

  /// Throws away what is pending (a deadline passed, the line was silent too long).
  void reset();

  /// Frames whose length field exceeds this are noise. Largest wanted reply plus its stuffing;
  /// default: what fits.
  void set_max_frame(std::size_t bytes) {
    max_frame_ = bytes < kMaxPacketBytes ? bytes : kMaxPacketBytes;
  }

  // skipped while searching, since construction
  std::uint32_t garbage_bytes() const { return garbage_bytes_; }
  std::uint32_t crc_errors() const { return crc_errors_; }

 private:
  void drop_byte();
  bool find_header();

  std::array<std::uint8_t, kMaxPacketBytes> buffer_{};
  std::size_t begin_ = 0;  // pending bytes are buffer_[begin_, end_)
  std::size_t end_ = 0;
  std::size_t frame_begin_ = 0;
  std::size_t frame_size_ = 0;
  std::size_t max_frame_ = kMaxPacketBytes;
  std::uint32_t garbage_bytes_ = 0;
  std::uint32_t crc_errors_ = 0;
};

/// One device's part of a fast reply.
struct FastBlock {
  std::uint8_t id = 0;
  std::uint8_t error = 0;
  std::span<const std::uint8_t> data;  // into the frame
};

/// Reads a fast reply block by block. Works on a reply that ends early: every block carries its own
/// CRC, so the devices before the gap are still good.
class FastReplyReader {
 public:
  /// `frame`: raw bytes from the header on (PacketParser::frame() or pending()).
  explicit FastReplyReader(std::span<const std::uint8_t> frame);

  /// The next block, which holds `data_length` bytes. empty: no more bytes; malformed: CRC wrong or
  /// no fast reply.
  Result<FastBlock> next(std::size_t data_length);

 private:
  std::span<const std::uint8_t> frame_;
  std::size_t offset_ = 0;
  std::uint16_t crc_ = 0;
};

}  // namespace sanso::servo_bus
