// The link thread's work: opens the host's datagrams, puts uploads together, hands commands and
// layers to the tick, and sends what the tick has published. Anything malformed, stale, replayed or
// unauthenticated is counted and dropped.
#pragma once

#include <memory>

#include "firmware/board/board.h"
#include "firmware/exchange/faults.h"
#include "firmware/exchange/handover.h"
#include "shared/policy/policy_bytes.h"
#include "shared/wire/secure_channel.h"
#include "shared/wire/upload.h"

namespace sanso::firmware {

class Link {
 public:
  Link(const wire::Key& key, board::Datagram& socket, board::Clock& clock, Handover& handover);

  /// Takes every datagram there is, waits for the first until `deadline`, then sends what is due.
  void poll(Nanoseconds deadline);

  bool connected() const { return channel_.established(); }
  std::uint32_t dropped() const { return channel_.dropped() + dropped_; }

 private:
  struct Upload {
    wire::UploadAssembler* assembler = nullptr;
    bool touched = false;  // an acknowledgement is due
    wire::UploadAck ack;
  };

  void take_datagram(std::span<const std::uint8_t> datagram);
  void take_message(std::span<const std::uint8_t> message);
  void take_command(const wire::Command& command);
  void take_chunk(const wire::UploadChunk& chunk);
  /// Reads a whole upload into its mailbox.
  Status deliver(wire::UploadKind kind, std::span<const std::uint8_t> blob);
  Upload& upload(wire::UploadKind kind) { return uploads_[static_cast<std::size_t>(kind) - 1]; }
  void new_session();
  void send_published();
  template <class Message>
  void send(const Message& message);

  board::Datagram& socket_;
  board::Clock& clock_;
  Handover& handover_;
  wire::SecureChannel channel_;
  board::Peer host_;    // where the last good datagram came from
  board::Peer sender_;  // of the datagram in hand
  std::uint32_t sessions_ = 0;

  wire::FixedUploadAssembler<policy::kMaxPrimitiveBytes> primitives_;
  wire::FixedUploadAssembler<policy::kMaxMiddleBytes> middle_;
  wire::FixedUploadAssembler<policy::kMaxUpperBytes> upper_;
  std::array<Upload, 3> uploads_;

  bool any_command_ = false;
  std::uint32_t last_command_ = 0;
  wire::CommandAck last_ack_;
  bool acked_ = false;
  std::uint32_t dropped_ = 0;
};

}  // namespace sanso::firmware
