// A state machine over a fixed buffer: search the header, wait for the length, check the CRC,
// remove the stuffing.
#include "shared/servo_bus/parser.h"

#include <cstring>

#include "shared/servo_bus/crc16.h"

namespace sanso::servo_bus {
namespace {

constexpr std::size_t kCrcBytes = 2;
constexpr std::size_t kMinLength = 3;  // instruction and CRC

/// Copies parameter bytes without the FD that follows every FF FF FD; the instruction counts as the
/// first of the three.
void unstuff(std::uint8_t instruction, std::span<const std::uint8_t> body,
             FixedVector<std::uint8_t, kMaxParameters + 1>& plain) {
  int matched = instruction == 0xFF ? 1 : 0;
  for (std::size_t i = 0; i < body.size(); ++i) {
    plain.try_push(body[i]);
    if (matched == 2 && body[i] == 0xFD) {
      if (i + 1 < body.size() && body[i + 1] == 0xFD) ++i;
      matched = 0;
    } else {
      matched = body[i] == 0xFF ? (matched < 2 ? matched + 1 : 2) : 0;
    }
  }
}

bool is_fast_reply(std::span<const std::uint8_t> frame) {
  return frame[4] == kBroadcastId &&
         frame[kInstructionOffset] == static_cast<std::uint8_t>(Instruction::status);
}

}  // namespace

std::size_t PacketParser::feed(std::span<const std::uint8_t> bytes) {
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  frame_size_ = 0;
  const std::size_t room = buffer_.size() - end_;
  const std::size_t count = bytes.size() < room ? bytes.size() : room;
  if (count > 0) std::memcpy(buffer_.data() + end_, bytes.data(), count);
  end_ += count;
  return count;
}

void PacketParser::reset() {
  garbage_bytes_ += static_cast<std::uint32_t>(end_ - begin_);
  begin_ = end_ = frame_begin_ = frame_size_ = 0;
}

void PacketParser::drop_byte() {
  ++begin_;
  ++garbage_bytes_;
}

/// Moves begin_ to the next FF FF FD 00 (or to a tail that may become one). False: not enough bytes
/// for a header.
bool PacketParser::find_header() {
  constexpr std::uint8_t kHeader[] = {0xFF, 0xFF, 0xFD, 0x00};
  for (; begin_ < end_; drop_byte()) {
    std::size_t matched = 0;
    while (matched < 4 && begin_ + matched < end_ && buffer_[begin_ + matched] == kHeader[matched])
      ++matched;
    if (matched == 4) return true;
    if (begin_ + matched == end_) return false;
  }
  return false;
}

ParseEvent PacketParser::next(Packet& packet) {
  frame_size_ = 0;
  while (find_header()) {
    if (end_ - begin_ < kHeaderBytes) return ParseEvent::none;
    const std::uint8_t* head = buffer_.data() + begin_;
    const std::size_t length = get_u16({head + 5, 2});
    const std::size_t size = kHeaderBytes + length;
    const bool id_ok = head[4] <= kMaxId || head[4] == kBroadcastId;
    if (!id_ok || length < kMinLength || size > max_frame_) {
      drop_byte();
      continue;
    }
    if (end_ - begin_ < size) return ParseEvent::none;

    const std::span<const std::uint8_t> frame{head, size};
    packet.id = head[4];
    packet.instruction = static_cast<Instruction>(head[kInstructionOffset]);
    packet.error = 0;
    packet.parameters.clear();
    if (crc16(frame.first(size - kCrcBytes)) != get_u16(frame.last(kCrcBytes))) {
      ++crc_errors_;
      drop_byte();
      return ParseEvent::crc_error;
    }

    frame_begin_ = begin_;
    frame_size_ = size;
    begin_ += size;
    // a fast reply is never stuffed, everything else is
    const auto body = frame.subspan(kInstructionOffset + 1, length - kMinLength);
    FixedVector<std::uint8_t, kMaxParameters + 1> plain;
    if (is_fast_reply(frame)) {
      plain.try_append(body);
    } else {
      unstuff(head[kInstructionOffset], body, plain);
    }
    auto parameters = plain.view();
    if (packet.is_status() && !is_fast_reply(frame)) {
      if (parameters.empty()) {  // a status without its error byte is no status
        ++garbage_bytes_;
        continue;
      }
      packet.error = parameters[0];
      parameters = parameters.subspan(1);
    }
    packet.parameters.try_append(parameters);
    return ParseEvent::packet;
  }
  return ParseEvent::none;
}

FastReplyReader::FastReplyReader(std::span<const std::uint8_t> frame) : frame_(frame) {
  constexpr std::size_t kStart = kInstructionOffset + 1;
  if (frame.size() < kStart || !is_fast_reply(frame)) return;  // offset_ 0 marks "not a fast reply"
  crc_ = crc16(frame.first(kStart));
  offset_ = kStart;
}

Result<FastBlock> FastReplyReader::next(std::size_t data_length) {
  if (offset_ == 0) return Status::malformed;
  const std::size_t size = data_length + 4;
  if (frame_.size() - offset_ < size) return Status::empty;
  const auto block = frame_.subspan(offset_, size);
  const std::uint16_t crc = crc16(block.first(size - kCrcBytes), crc_);
  if (crc != get_u16(block.last(kCrcBytes))) {
    offset_ = 0;  // every later CRC covers the damaged bytes too
    return Status::malformed;
  }
  crc_ = crc16(block.last(kCrcBytes), crc);
  offset_ += size;
  return FastBlock{block[1], block[0], block.subspan(2, data_length)};
}

}  // namespace sanso::servo_bus
