// One poll: datagrams in until the deadline, then whatever the tick has published out. An
// unknown sender never gets further than the handshake.
#include "firmware/link/link.h"

#include "shared/policy/primitives.h"
#include "shared/wire/codec.h"

namespace sanso::firmware {
namespace {
constexpr int kMaxDatagramsAtOnce = 256;
}

Link::Link(const wire::Key& key, board::Datagram& socket, board::Clock& clock, Handover& handover)
    : socket_(socket), clock_(clock), handover_(handover), channel_(wire::Role::controller, key) {
  upload(wire::UploadKind::primitives).assembler = &*primitives_;
  upload(wire::UploadKind::middle_table).assembler = &*middle_;
  upload(wire::UploadKind::upper_policy).assembler = &*upper_;
}

void Link::poll(Nanoseconds deadline) {
  // one more: a longer one shows as too long
  std::array<std::uint8_t, wire::kMaxDatagram + 1> datagram;
  for (int i = 0; i < kMaxDatagramsAtOnce; ++i) {
    const Result<std::size_t> n = socket_.receive(datagram, sender_, i == 0 ? deadline : 0);
    if (!n.ok() || *n == 0) break;
    take_datagram(std::span(datagram).first(*n));
  }
  handover_.datagrams_dropped.store(dropped(), std::memory_order_relaxed);
  send_published();
}

void Link::take_datagram(std::span<const std::uint8_t> datagram) {
  std::array<std::uint8_t, wire::kMaxDatagram> message, reply;
  const auto opened = channel_.open(datagram, message, reply);
  if (opened.reply_bytes > 0)
    (void)socket_.send(std::span(reply).first(opened.reply_bytes), sender_);
  if (opened.status != Status::ok) return;
  if (channel_.sessions() != sessions_) new_session();
  host_ = sender_;
  handover_.host_heard.store(clock_.now(), std::memory_order_relaxed);
  take_message(std::span(message).first(opened.message_bytes));
}

/// A new session is a new host: nothing half-finished of the old one may mix with it.
void Link::new_session() {
  sessions_ = channel_.sessions();
  any_command_ = acked_ = false;
  for (Upload& u : uploads_) {
    u.assembler->reset();
    u.ack = wire::UploadAck{};
    u.touched = false;
  }
}

void Link::take_message(std::span<const std::uint8_t> message) {
  const Result<wire::MessageType> type = wire::message_type(message);
  wire::Command command;
  wire::UploadChunk chunk;
  if (type.ok() && *type == wire::MessageType::command &&
      wire::decode(message, command) == Status::ok)
    take_command(command);
  else if (type.ok() && *type == wire::MessageType::upload_chunk &&
           wire::decode(message, chunk) == Status::ok)
    take_chunk(chunk);
  else
    ++dropped_;
}

void Link::take_command(const wire::Command& command) {
  if (command.sequence == 0) return;  // a sign of life
  const bool repeated = any_command_ && command.sequence == last_command_;
  if (repeated) {
    if (acked_) send(last_ack_);  // its acknowledgement was lost
    return;
  }
  if (any_command_ && static_cast<std::int32_t>(command.sequence - last_command_) < 0) {
    ++dropped_;  // overtaken by a later one
    return;
  }
  if (!handover_.commands.push(command)) return;  // full: the host will repeat it
  any_command_ = true;
  acked_ = false;
  last_command_ = command.sequence;
}

void Link::take_chunk(const wire::UploadChunk& chunk) {
  Upload& u = upload(chunk.kind);
  const bool known = u.ack.upload_id == chunk.upload_id && (u.ack.complete || u.ack.refused);
  u.touched = true;
  if (known) return;  // a repeated piece of an upload that is settled: acknowledge again
  u.ack = wire::UploadAck{};
  u.ack.kind = chunk.kind;
  u.ack.upload_id = chunk.upload_id;
  const Status status = u.assembler->accept(chunk);
  Refusal refusal = Refusal::none;
  if (status == Status::full)
    refusal = Refusal::upload_size;
  else if (status == Status::rejected)
    refusal = Refusal::upload_checksum;
  else if (status != Status::ok)
    ++dropped_;
  else if (u.assembler->complete() && deliver(chunk.kind, u.assembler->blob()) != Status::ok)
    refusal = Refusal::upload_contents;
  u.ack.first_missing = u.assembler->first_missing();
  u.ack.refused = refusal != Refusal::none ? 1 : 0;
  u.ack.reason = static_cast<std::uint16_t>(refusal);
  u.ack.complete =
      status == Status::ok && refusal == Refusal::none && u.assembler->complete() ? 1 : 0;
}

Status Link::deliver(wire::UploadKind kind, std::span<const std::uint8_t> blob) {
  const auto into = [&](auto& mailbox) {
    const Status status = policy::from_bytes(blob, mailbox.back());
    if (status == Status::ok) mailbox.publish();
    return status;
  };
  switch (kind) {
    case wire::UploadKind::primitives:
      return into(handover_.primitives);
    case wire::UploadKind::middle_table:
      return into(handover_.middle);
    case wire::UploadKind::upper_policy:
      return into(handover_.upper);
  }
  return Status::malformed;
}

void Link::send_published() {
  for (Upload& u : uploads_) {
    if (!u.touched) continue;
    u.touched = false;
    send(u.ack);
  }
  wire::CommandAck ack;
  while (handover_.acks.pop(ack)) {
    if (ack.sequence != last_command_) continue;  // of a session that is over
    last_ack_ = ack;
    acked_ = true;
    send(ack);
  }
  wire::Observation observation;
  while (handover_.observations.pop(observation)) send(observation);
}

template <class Message>
void Link::send(const Message& message) {
  if (host_.size == 0) return;
  std::array<std::uint8_t, wire::kMaxDatagram> plain, sealed;
  const Result<std::size_t> n = wire::encode(message, plain);
  if (!n.ok()) return;
  const Result<std::size_t> m = channel_.seal(std::span(plain).first(*n), sealed);
  if (m.ok()) (void)socket_.send(std::span(sealed).first(*m), host_);
}

}  // namespace sanso::firmware
