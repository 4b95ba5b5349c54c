// The host's end of the wire: handshake, uploads and commands that are repeated until acknowledged,
// policies that are sent once, observations as they come. One implementation for the robot, the
// emulator and the in-process robot.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/link/channel.h"
#include "shared/base/status.h"
#include "shared/policy/policy_types.h"
#include "shared/wire/messages.h"
#include "shared/wire/secure_channel.h"

namespace sanso::link {

struct LinkSettings {
  // hello, command or chunks are sent again after this silence
  Nanoseconds retry_period = 40 * kMillisecond;
  Nanoseconds patience = 3 * kSecond;  // then the call gives up with Status::timeout
  // of an upload; bounds what the controller has to buffer in one tick
  std::size_t chunks_in_flight = 16;
};

class RobotLink {
 public:
  /// `channel` and `clock` must outlive the link.
  RobotLink(DatagramChannel& channel, HostClock& clock, const wire::Key& preshared,
            const LinkSettings& settings = {});

  /// Opens a session. ok, or timeout when no controller with this key answers; then identity() may
  /// say who is there all the same.
  Status open();
  /// Who answered in the clear, when somebody did: another key or another version.
  const std::optional<wire::Identity>& identity() const { return identity_; }

  /// Brings a blob to the controller. ok when the controller holds it whole and found its contents
  /// valid; rejected when it refused them (refusal() has the number); timeout.
  Status upload(wire::UploadKind kind, std::span<const std::uint8_t> blob);
  Status upload(const policy::MiddleTable& table);

  /// Carries out `command` (its sequence number is set here) exactly once. ok, rejected or timeout.
  Status command(wire::Command command);

  /// Sends a policy, without waiting: the next one is worth more than a repetition. Call with
  /// rounded numbers.
  void send_policy(const policy::UpperPolicy& policy);

  /// Tells the controller that the host is there: it ends a trial when it hears nothing
  /// (docs/wire.md).
  void send_sign_of_life();

  /// Reads what has arrived. Called by everything that waits; call it before looking at
  /// observations.
  void poll();
  /// Returns when `time` is reached or an observation newer than the last seen has arrived.
  void wait_observation(Nanoseconds time);

  /// The newest observation; tick 0 before the first.
  const wire::Observation& latest() const { return latest_; }
  /// All observations since the last call, oldest first.
  std::vector<wire::Observation> take_observations();

  HostClock& clock() { return clock_; }
  // fault or refusal number of the last rejection, docs/faults.md
  std::uint16_t refusal() const { return refusal_; }
  std::uint32_t dropped() const { return secure_.dropped(); }

 private:
  template <class Message>
  void send(const Message& message);
  void take_datagram(std::span<const std::uint8_t> datagram);
  void take_message(std::span<const std::uint8_t> message);
  void take_observation(const wire::Observation& observation);
  /// Polls until `done` or `deadline`; true when done.
  template <class Condition>
  bool wait_for(Condition done, Nanoseconds deadline);
  void send_chunks(wire::UploadKind kind, std::uint32_t id, std::span<const std::uint8_t> blob,
                   std::uint32_t checksum, std::size_t begin, std::size_t end);

  DatagramChannel& channel_;
  HostClock& clock_;
  LinkSettings settings_;
  wire::SecureChannel secure_;
  wire::Observation latest_;
  std::vector<wire::Observation> unread_;
  wire::CommandAck command_ack_;
  wire::UploadAck upload_ack_;
  std::optional<wire::Identity> identity_;
  std::uint32_t next_sequence_ = 1;
  std::uint32_t next_upload_ = 1;
  std::uint16_t refusal_ = 0;
};

/// The way out of a fault: clears it, after lowering a robot that the servos still hold. ok,
/// rejected (the bus is gone, or the robot does not come down within ten seconds) or timeout.
Status lower_and_clear(RobotLink& robot);

}  // namespace sanso::link
