// The two seams through which the host meets a robot: a path for datagrams and a clock. Over UDP
// both are the operating system's; in process both are simulated, and waiting is what makes the
// robot live.
#pragma once

#include <cstddef>
#include <cstdint>

#include "shared/base/time.h"

namespace sanso::link {

/// A bidirectional datagram path. Neither call blocks.
class DatagramChannel {
 public:
  virtual ~DatagramChannel() = default;
  /// False when the path refused the datagram (the caller retries as it would after a loss).
  virtual bool send(const std::uint8_t* data, std::size_t size) = 0;
  /// Bytes written to `buffer`; 0 when nothing has arrived.
  virtual std::size_t receive(std::uint8_t* buffer, std::size_t capacity) = 0;
};

/// The host's time; monotonic, never wall-clock time.
class HostClock {
 public:
  virtual ~HostClock() = default;
  /// Since a fixed moment; never goes back.
  virtual Nanoseconds now() = 0;
  /// Returns at `time`, or earlier when a datagram may have arrived.
  virtual void wait_until(Nanoseconds time) = 0;
  /// Ends a computation that began at `begin`. In process, computing takes no virtual time by
  /// itself: the clock moves to `begin + modelled`, so that results do not depend on the machine. A
  /// real clock has moved by itself.
  virtual void finish_computation(Nanoseconds begin, Nanoseconds modelled) = 0;
};

}  // namespace sanso::link
