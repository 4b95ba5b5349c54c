// The link thread's work: opens the host's datagrams, puts uploads together, hands commands and
// layers to the tick, and sends what the tick has published. Anything malformed, stale, replayed or
// unauthenticated is counted and dropped. One host owns the robot and gives the orders; others
// watch, and one of them may take over when the owner has been silent for a while. An emergency
// stop is taken from everybody who holds the key.
#pragma once

#include <memory>
#include <string>

#include "firmware/board/board.h"
#include "firmware/exchange/faults.h"
#include "firmware/exchange/handover.h"
#include "shared/policy/policy_bytes.h"
#include "shared/wire/secure_channel.h"
#include "shared/wire/upload.h"

namespace sanso::firmware {

class Link {
 public:
  Link(const wire::Key& key, board::Datagram& socket, board::Clock& clock, Handover& handover,
       const std::string& robot_name = {});

  /// Takes every datagram there is, waits for the first until `deadline`, then sends what is due.
  void poll(Nanoseconds deadline);

  bool connected() const { return channel_.established(); }
  std::uint32_t dropped() const { return channel_.dropped() + dropped_ + socket_.empty_ones(); }
  /// Why datagrams were dropped before they were messages.
  const wire::DropCounts& drops() const { return channel_.drops(); }

 private:
  struct Upload {
    wire::UploadAssembler* assembler = nullptr;
    bool touched = false;  // an acknowledgement is due
    wire::UploadAck ack;
  };

  /// A host that has proved that it holds the key.
  struct Host {
    board::Peer peer;  // where its last good datagram came from
    Nanoseconds heard = 0;
    bool known = false;
    // its commands
    bool any_command = false, acked = false;
    std::uint32_t last_command = 0;
    wire::CommandAck last_ack;
  };

  void take_datagram(std::span<const std::uint8_t> datagram);
  bool answer_who(std::span<const std::uint8_t> datagram);
  void forget_the_silent();
  bool may_order(int session);
  void refuse(const wire::Command& command, Refusal refusal);
  void take_message(std::span<const std::uint8_t> message);
  void take_command(const wire::Command& command);
  void take_chunk(const wire::UploadChunk& chunk);
  /// Reads a whole upload into its mailbox.
  Status deliver(wire::UploadKind kind, std::span<const std::uint8_t> blob);
  Upload& upload(wire::UploadKind kind) { return uploads_[static_cast<std::size_t>(kind) - 1]; }
  void new_session(int session);
  void new_owner(int session);
  void send_published();
  template <class Message>
  void send(const Message& message, int session);

  board::Datagram& socket_;
  board::Clock& clock_;
  Handover& handover_;
  wire::SecureChannel channel_;
  wire::Identity identity_;
  std::array<Host, wire::SecureChannel::kMaxSessions> hosts_;
  int owner_ = -1;                  // session whose orders count
  bool owner_has_ordered_ = false;  // until then it only looks, and whoever orders first owns
  board::Peer sender_;              // of the datagram in hand
  int session_ = 0;                 // in which it opened
  std::uint32_t sessions_ = 0;
  std::uint64_t newest_tick_ = 0;  // published
  wire::SupervisorState newest_state_ = wire::SupervisorState::boot;

  wire::FixedUploadAssembler<policy::kMaxPrimitiveBytes> primitives_;
  wire::FixedUploadAssembler<policy::kMaxMiddleBytes> middle_;
  wire::FixedUploadAssembler<policy::kMaxUpperBytes> upper_;
  std::array<Upload, 3> uploads_;

  std::uint32_t dropped_ = 0;
};

}  // namespace sanso::firmware
