// What the host needs of a robot: upload a trial, run it, watch it, feed it policies. One interface for the robot, the
// emulator (both over UDP) and the in-process robot (same bytes, virtual clock).
#pragma once

#include <optional>
#include <string>

#include "shared/policy/policy_types.h"
#include "shared/policy/primitives.h"
#include "shared/wire/messages.h"

namespace sanso::host {

/// A bidirectional datagram path. Send never blocks; receive returns what has arrived.
class DatagramChannel {
 public:
  virtual ~DatagramChannel() = default;
  virtual bool send(const std::uint8_t* data, std::size_t size) = 0;
  /// Bytes written to `buffer`, 0 when nothing has arrived.
  virtual std::size_t receive(std::uint8_t* buffer, std::size_t capacity) = 0;
};

/// The host's time. In process it is virtual: wait_until() is what makes the robot live.
class HostClock {
 public:
  virtual ~HostClock() = default;
  virtual Nanoseconds now() = 0;                 // monotonic
  virtual void wait_until(Nanoseconds time) = 0; // returns at or after `time`
};

}  // namespace sanso::host
