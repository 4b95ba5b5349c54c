// One poll: datagrams in until the deadline, then whatever the tick has published out. An
// unknown sender never gets further than the handshake.
#include "firmware/link/link.h"

#include <algorithm>

#include "shared/policy/primitives.h"
#include "shared/wire/codec.h"

namespace sanso::firmware {
namespace {
constexpr int kMaxDatagramsAtOnce = 256;

bool same_peer(const board::Peer& a, const board::Peer& b) {
  return a.size == b.size && std::equal(a.bytes, a.bytes + a.size, b.bytes);
}

}  // namespace

Link::Link(const wire::Key& key, board::Datagram& socket, board::Clock& clock, Handover& handover,
           const std::string& robot_name)
    : socket_(socket), clock_(clock), handover_(handover), channel_(wire::Role::controller, key) {
  upload(wire::UploadKind::primitives).assembler = &*primitives_;
  upload(wire::UploadKind::middle_table).assembler = &*middle_;
  upload(wire::UploadKind::upper_policy).assembler = &*upper_;
  const std::size_t n = std::min(robot_name.size(), identity_.robot_name.size() - 1);
  std::copy_n(robot_name.begin(), n, identity_.robot_name.begin());
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
  forget_the_silent();
  send_published();
}

void Link::take_datagram(std::span<const std::uint8_t> datagram) {
  if (answer_who(datagram)) return;
  std::array<std::uint8_t, wire::kMaxDatagram> message, reply;
  const auto opened = channel_.open(datagram, message, reply);
  if (opened.reply_bytes > 0)
    (void)socket_.send(std::span(reply).first(opened.reply_bytes), sender_);
  if (opened.status != Status::ok) return;
  session_ = opened.session;
  if (channel_.sessions() != sessions_) new_session(session_);
  Host& host = hosts_[static_cast<std::size_t>(session_)];
  host.peer = sender_;
  host.heard = clock_.now();
  if (session_ == owner_) handover_.host_heard.store(host.heard, std::memory_order_relaxed);
  take_message(std::span(message).first(opened.message_bytes));
}

/// Answers in the clear who is here, in no more bytes than were asked with.
bool Link::answer_who(std::span<const std::uint8_t> datagram) {
  std::array<std::uint8_t, wire::kIdentityBytes> answer;
  if (!wire::is_who(datagram)) return false;
  wire::encode_identity(identity_, answer);
  (void)socket_.send(answer, sender_);
  return true;
}

// --- who may give orders -------------------------------------------------------------------------

/// A new session is a new program. It owns the robot when nobody does, until another one gives an
/// order before it; or when it speaks from the very address of the owner, which then is gone.
void Link::new_session(int session) {
  sessions_ = channel_.sessions();
  Host& host = hosts_[static_cast<std::size_t>(session)];
  host = Host{};
  host.known = true;
  const bool same_place = owner_ >= 0 && owner_ != session &&
                          same_peer(hosts_[static_cast<std::size_t>(owner_)].peer, sender_);
  if (same_place) channel_.close(owner_);
  if (same_place) hosts_[static_cast<std::size_t>(owner_)] = Host{};
  const bool ordered = same_place && owner_has_ordered_;
  if (owner_ < 0 || owner_ == session || same_place) {
    new_owner(session);
    owner_has_ordered_ = ordered;
  }
}

/// Nothing half-finished of the old owner may mix with what the new one sends.
void Link::new_owner(int session) {
  owner_ = session;
  owner_has_ordered_ = false;
  for (Upload& u : uploads_) {
    u.assembler->reset();
    u.ack = wire::UploadAck{};
    u.touched = false;
  }
}

/// The session in hand owns the robot, or may take it over because the owner has only looked so far
/// or its lease has run out.
bool Link::may_order(int session) {
  if (session != owner_) {
    if (owner_ >= 0 && owner_has_ordered_ &&
        clock_.now() - hosts_[static_cast<std::size_t>(owner_)].heard < wire::kOwnerLease)
      return false;
    new_owner(session);
    handover_.host_heard.store(clock_.now(), std::memory_order_relaxed);
  }
  owner_has_ordered_ = true;
  return true;
}

/// A watcher that says nothing any more gets nothing any more; the place that has been silent for
/// longest is the one that a newcomer may have.
void Link::forget_the_silent() {
  const Nanoseconds now = clock_.now();
  int oldest = -1;
  for (int i = 0; i < static_cast<int>(hosts_.size()); ++i) {
    Host& host = hosts_[static_cast<std::size_t>(i)];
    if (!host.known || now - host.heard < wire::kOwnerLease) continue;
    if (oldest < 0 || host.heard < hosts_[static_cast<std::size_t>(oldest)].heard) oldest = i;
  }
  channel_.offer(oldest);
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

void Link::refuse(const wire::Command& command, Refusal refusal) {
  Host& host = hosts_[static_cast<std::size_t>(session_)];
  host.any_command = host.acked = true;
  host.last_command = command.sequence;
  host.last_ack = {command.sequence, 0, newest_state_, static_cast<std::uint16_t>(refusal)};
  send(host.last_ack, session_);
}

void Link::take_command(const wire::Command& command) {
  // before everything else, from everybody, however old
  if (command.kind == wire::CommandKind::emergency_stop) handover_.emergency_stop.store(true);
  if (command.sequence == 0) return;  // a sign of life
  Host& host = hosts_[static_cast<std::size_t>(session_)];
  const bool repeated = host.any_command && command.sequence == host.last_command;
  if (repeated) {
    if (host.acked) send(host.last_ack, session_);  // its acknowledgement was lost
    return;
  }
  if (host.any_command && static_cast<std::int32_t>(command.sequence - host.last_command) < 0) {
    ++dropped_;  // overtaken by a later one
    return;
  }
  const bool asks = command.kind == wire::CommandKind::none;
  const bool stops = command.kind == wire::CommandKind::emergency_stop;
  if (!asks && !stops) {
    if (command.observed_tick + wire::kCommandLife_ticks < newest_tick_)
      return refuse(command, Refusal::stale_command);
    if (!may_order(session_)) return refuse(command, Refusal::not_owner);
  }
  if (asks || stops) {  // nothing for the tick, or already with it
    host.any_command = host.acked = true;
    host.last_command = command.sequence;
    host.last_ack = {command.sequence, 1, newest_state_, 0};
    return send(host.last_ack, session_);
  }
  if (!handover_.commands.push(command)) return;  // full: the host will repeat it
  host.any_command = true;
  host.acked = false;
  host.last_command = command.sequence;
}

void Link::take_chunk(const wire::UploadChunk& chunk) {
  Upload& u = upload(chunk.kind);
  if (!may_order(session_)) {
    wire::UploadAck refused;
    refused.kind = chunk.kind;
    refused.upload_id = chunk.upload_id;
    refused.refused = 1;
    refused.reason = static_cast<std::uint16_t>(Refusal::not_owner);
    return send(refused, session_);
  }
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
    if (owner_ >= 0) send(u.ack, owner_);
  }
  wire::CommandAck ack;
  while (handover_.acks.pop(ack)) {
    if (owner_ < 0) continue;
    Host& owner = hosts_[static_cast<std::size_t>(owner_)];
    if (!owner.any_command || ack.sequence != owner.last_command) continue;  // of an earlier owner
    owner.last_ack = ack;
    owner.acked = true;
    send(ack, owner_);
  }
  wire::Observation observation;
  const Nanoseconds now = clock_.now();
  while (handover_.observations.pop(observation)) {
    newest_tick_ = observation.tick;
    newest_state_ = observation.state;
    for (int i = 0; i < static_cast<int>(hosts_.size()); ++i)
      if (i == owner_ || now - hosts_[static_cast<std::size_t>(i)].heard < wire::kOwnerLease)
        send(observation, i);
  }
}

template <class Message>
void Link::send(const Message& message, int session) {
  const Host& host = hosts_[static_cast<std::size_t>(session)];
  if (!host.known || host.peer.size == 0) return;
  std::array<std::uint8_t, wire::kMaxDatagram> plain, sealed;
  const Result<std::size_t> n = wire::encode(message, plain);
  if (!n.ok()) return;
  const Result<std::size_t> m = channel_.seal(std::span(plain).first(*n), sealed, session);
  if (m.ok()) (void)socket_.send(std::span(sealed).first(*m), host.peer);
}

}  // namespace sanso::firmware
