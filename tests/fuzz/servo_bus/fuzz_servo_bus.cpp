// Any bytes, in any pieces: the parser never reads outside, always makes progress, and what it
// accepts encodes again to the same frame.
#include <cstdlib>

#include "shared/servo_bus/encode.h"
#include "shared/servo_bus/parser.h"

using namespace sanso::servo_bus;

namespace {

void check(const PacketParser& parser, const Packet& packet) {
  const auto frame = parser.frame();
  if (packet.id == kBroadcastId && packet.is_status()) {
    FastReplyReader reader(frame);
    while (reader.next(4).ok()) {
    }
    return;
  }
  PacketBuffer again;
  const auto status = packet.is_status()
                          ? encode_status(again, packet.id, packet.error, packet.parameters.view())
                          : encode(again, packet.id, packet.instruction, packet.parameters.view());
  // unstuffed senders may fill the buffer to the last byte
  if (status != sanso::Status::ok) return;
  PacketParser second;
  second.feed(again.view());
  Packet repeated;
  if (second.next(repeated) != ParseEvent::packet ||
      repeated.parameters.size() != packet.parameters.size())
    abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  PacketParser parser;
  Packet packet;
  std::size_t piece = 1;
  while (size > 0) {
    const std::size_t count = piece < size ? piece : size;
    const std::size_t taken = parser.feed({data, count});
    data += taken;
    size -= taken;
    piece = piece % 37 + 5;
    for (ParseEvent event; (event = parser.next(packet)) != ParseEvent::none;) {
      if (event == ParseEvent::packet) check(parser, packet);
    }
    if (taken == 0) parser.reset();
  }
  return 0;
}
