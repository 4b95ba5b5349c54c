// Everything that waits polls the channel until its condition holds or its deadline passes; what
// arrives meanwhile is sorted by type.
#include "host/link/robot_link.h"

#include <algorithm>
#include <array>

#include "shared/base/crc32.h"
#include "shared/policy/policy_bytes.h"
#include "shared/wire/codec.h"
#include "shared/wire/upload.h"

namespace sanso::link {

// refusals that pass, by themselves or with the robot on the ground (docs/faults.md)
constexpr std::uint16_t kTorqueOn = 105, kStaleCommand = 124, kNotOwner = 125;

using Datagram = std::array<std::uint8_t, wire::kMaxDatagram>;

RobotLink::RobotLink(DatagramChannel& channel, HostClock& clock, const wire::Key& preshared,
                     const LinkSettings& settings)
    : channel_(channel), clock_(clock), settings_(settings), secure_(wire::Role::host, preshared) {}

// --- waiting and receiving -----------------------------------------------------------------------

void RobotLink::poll() {
  Datagram buffer;
  for (std::size_t n = channel_.receive(buffer.data(), buffer.size()); n > 0;
       n = channel_.receive(buffer.data(), buffer.size()))
    take_datagram(std::span(buffer).first(n));
}

void RobotLink::take_datagram(std::span<const std::uint8_t> datagram) {
  Datagram message, reply;
  if (wire::Identity identity; wire::decode_identity(datagram, identity) == Status::ok) {
    identity_ = identity;
    return;
  }
  const auto opened = secure_.open(datagram, message, reply);
  if (opened.reply_bytes > 0) channel_.send(reply.data(), opened.reply_bytes);
  if (opened.status == Status::ok) take_message(std::span(message).first(opened.message_bytes));
}

void RobotLink::take_message(std::span<const std::uint8_t> message) {
  const Result<wire::MessageType> type = wire::message_type(message);
  if (!type.ok()) return;
  switch (*type) {
    case wire::MessageType::observation: {
      wire::Observation o;
      if (wire::decode(message, o) == Status::ok) take_observation(o);
      break;
    }
    case wire::MessageType::command_ack:
      (void)wire::decode(message, command_ack_);
      break;
    case wire::MessageType::upload_ack:
      (void)wire::decode(message, upload_ack_);
      break;
    default:
      break;  // nothing else is for the host
  }
}

void RobotLink::take_observation(const wire::Observation& observation) {
  unread_.push_back(observation);
  // datagrams may overtake one another
  if (observation.tick > latest_.tick || latest_.tick == 0) latest_ = observation;
}

std::vector<wire::Observation> RobotLink::take_observations() {
  std::vector<wire::Observation> out;
  out.swap(unread_);
  std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.tick < b.tick; });
  return out;
}

template <class Condition>
bool RobotLink::wait_for(Condition done, Nanoseconds deadline) {
  for (poll(); !done(); poll()) {
    if (clock_.now() >= deadline) return false;
    clock_.wait_until(deadline);
  }
  return true;
}

void RobotLink::wait_observation(Nanoseconds time) {
  const std::uint64_t before = latest_.tick;
  (void)wait_for([&] { return latest_.tick != before; }, time);
}

// --- sending -------------------------------------------------------------------------------------

template <class Message>
void RobotLink::send(const Message& message) {
  Datagram plain, sealed;
  const Result<std::size_t> n = wire::encode(message, plain);
  if (!n.ok()) return;
  const Result<std::size_t> m = secure_.seal(std::span(plain).first(*n), sealed);
  if (m.ok()) channel_.send(sealed.data(), *m);
}

Status RobotLink::open() {
  const Nanoseconds begin = clock_.now(), give_up = begin + settings_.patience;
  const std::uint32_t before = secure_.sessions();
  const std::uint64_t seen = latest_.tick;
  bool fresh = true;
  Datagram hello;
  std::array<std::uint8_t, wire::kIdentityBytes> who;
  wire::encode_who(who);
  while (clock_.now() < give_up) {
    const Result<std::size_t> n = secure_.make_hello(hello, fresh);
    if (!n.ok()) return n.status();
    fresh = false;
    channel_.send(hello.data(), *n);
    if (clock_.now() > begin + settings_.patience / 2) channel_.send(who.data(), who.size());
    if (wait_for([&] { return secure_.sessions() != before; },
                 clock_.now() + settings_.retry_period)) {
      // The controller counts the session as open with the first message in it: a command that asks
      // for nothing.
      const Status first = command({});
      if (first == Status::timeout) return first;
      return wait_for([&] { return latest_.tick != seen; }, give_up) ? Status::ok : Status::timeout;
    }
  }
  return Status::timeout;
}

Status RobotLink::command(wire::Command command) {
  command.sequence = next_sequence_++;
  const Nanoseconds give_up = clock_.now() + settings_.patience;
  while (clock_.now() < give_up) {
    command.observed_tick = latest_.tick;
    send(command);
    if (!wait_for([&] { return command_ack_.sequence == command.sequence; },
                  clock_.now() + settings_.retry_period))
      continue;
    refusal_ = command_ack_.reason;
    if (command_ack_.accepted) return Status::ok;
    // it was long on its way, or the owner before us has just gone: ask anew
    if (refusal_ != kStaleCommand && refusal_ != kNotOwner) return Status::rejected;
    command.sequence = next_sequence_++;
    wait_observation(clock_.now() + settings_.retry_period);
  }
  return refusal_ == kNotOwner ? Status::rejected : Status::timeout;
}

void RobotLink::send_chunks(wire::UploadKind kind, std::uint32_t id,
                            std::span<const std::uint8_t> blob, std::uint32_t checksum,
                            std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) send(wire::make_chunk(kind, id, blob, checksum, i));
}

Status RobotLink::upload(wire::UploadKind kind, std::span<const std::uint8_t> blob) {
  const std::uint32_t id = next_upload_++;
  const std::uint32_t checksum = crc32(blob);
  const std::size_t count = wire::chunk_count(blob.size());
  Nanoseconds give_up = clock_.now() + settings_.patience;
  std::size_t missing = 0;  // first chunk that the controller has not acknowledged
  while (clock_.now() < give_up) {
    const std::size_t end = std::min(missing + settings_.chunks_in_flight, count);
    send_chunks(kind, id, blob, checksum, missing, end);
    const auto answered = [&] {
      return upload_ack_.kind == kind && upload_ack_.upload_id == id &&
             (upload_ack_.complete || upload_ack_.refused || upload_ack_.first_missing >= end);
    };
    const bool progressed = wait_for(answered, clock_.now() + settings_.retry_period);
    const bool ours = upload_ack_.kind == kind && upload_ack_.upload_id == id;
    if (ours && upload_ack_.refused) {
      refusal_ = upload_ack_.reason;
      return Status::rejected;
    }
    if (ours && upload_ack_.complete) return Status::ok;
    if (ours) missing = std::min<std::size_t>(upload_ack_.first_missing, count - 1);
    if (progressed) give_up = clock_.now() + settings_.patience;
  }
  return Status::timeout;
}

Status RobotLink::upload(const policy::MiddleTable& table) {
  std::vector<std::uint8_t> bytes(policy::kMaxMiddleBytes);
  const Result<std::size_t> n = policy::to_bytes(table, bytes);
  if (!n.ok()) return n.status();
  return upload(wire::UploadKind::middle_table, std::span(bytes).first(*n));
}

void RobotLink::send_sign_of_life() { send(wire::Command{}); }

void RobotLink::send_policy(const policy::UpperPolicy& policy) {
  std::array<std::uint8_t, policy::kMaxUpperBytes> bytes;
  const Result<std::size_t> n = policy::to_bytes(policy, bytes);
  if (!n.ok()) return;
  const std::span<const std::uint8_t> blob = std::span(bytes).first(*n);
  send_chunks(wire::UploadKind::upper_policy, next_upload_++, blob, crc32(blob), 0,
              wire::chunk_count(blob.size()));
}

Status lower_and_clear(RobotLink& robot) {
  constexpr Nanoseconds kPatience = 10 * kSecond, kPause = 200 * kMillisecond;
  const Nanoseconds give_up = robot.clock().now() + kPatience;
  for (;;) {
    const Status cleared = robot.command({.kind = wire::CommandKind::clear_fault});
    if (cleared != Status::rejected || robot.refusal() != kTorqueOn) return cleared;
    if (robot.clock().now() >= give_up) return Status::rejected;
    (void)robot.command({.kind = wire::CommandKind::lower});
    for (const Nanoseconds end = robot.clock().now() + kPause; robot.clock().now() < end;)
      robot.wait_observation(end);
  }
}

}  // namespace sanso::link
