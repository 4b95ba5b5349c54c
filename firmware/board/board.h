// The seam between the controller and the hardware. Everything that firmware/ knows of the world
// passes through these five interfaces; on the robot they are Linux devices, in tests and in
// process they are simulated with a virtual clock.
// None of the calls allocates; none throws.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/base/realtime.h"
#include "shared/base/status.h"
#include "shared/base/time.h"

namespace sanso::board {

using Bytes = std::span<const std::uint8_t>;
using Buffer = std::span<std::uint8_t>;

/// Monotonic time since some fixed moment. In virtual time, sleeping and waiting for bytes are what
/// makes it pass.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Since that moment; never goes back.
  virtual Nanoseconds now() SANSO_REALTIME = 0;
  /// CPU time that the calling thread has used. Virtual clocks say 0: results must not depend on
  /// the machine.
  virtual Nanoseconds thread_cpu() SANSO_REALTIME { return 0; }
};

/// The half-duplex servo bus. Used by the tick thread only.
class SerialPort {
 public:
  virtual ~SerialPort() = default;
  /// Queues all bytes for sending. io_error: the device is gone (unplugged); it stays so until
  /// ready().
  virtual Status write(Bytes data) SANSO_REALTIME = 0;
  /// Bytes that have arrived, as soon as there is at least one; waits for it until `deadline` at
  /// most (a deadline in the past: takes what is there). Returns 0 at the deadline. io_error as for
  /// write().
  virtual Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) SANSO_REALTIME = 0;
  /// Asks whether a lost device is back: ok, or why not. Does not block and does not allocate:
  /// opening is the helper thread's work (reconnect.h).
  virtual Status ready() SANSO_REALTIME = 0;
};

/// Which device it is; 0:0 when nobody knows.
struct HidIdentity {
  std::uint16_t vendor = 0, product = 0;
};

/// Input reports of a HID sensor, one at a time, each beginning with its report ID when the device
/// numbers its reports. Used by the IMU thread only.
class HidSource {
 public:
  virtual ~HidSource() = default;
  /// The report descriptor; empty while the device is not there. Its memory belongs to the source
  /// and stays valid until the device is lost.
  virtual Bytes descriptor() = 0;
  /// Vendor and product, as far as the source knows them.
  virtual HidIdentity identity() { return {}; }
  /// Sends a feature report: report ID first, 0 for a device that does not number its reports.
  virtual Status set_feature(Bytes report) = 0;
  /// Reads a feature report: the ID goes in as the first byte, ID and data come out. Bytes read.
  virtual Result<std::size_t> get_feature(Buffer) { return Status::unsupported; }
  /// The reader cannot use this device: look again later, it may have been replaced.
  virtual void reject() {}
  /// The next report; waits until `deadline` at most. 0: none came. io_error: unplugged.
  virtual Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) = 0;
};

/// Pose of the base from outside (tracking camera), as the bytes of shared/base/pose_report.h. May
/// be absent.
class PoseSource {
 public:
  virtual ~PoseSource() = default;
  /// The next report; waits until `deadline` at most. 0: none came. io_error: the source is gone.
  virtual Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) = 0;
};

/// Where a datagram came from; opaque, owned by the implementation.
struct Peer {
  std::uint8_t size = 0;  // 0: nobody
  std::uint8_t bytes[28] = {};
};

/// Datagrams to and from hosts. Used by the link thread only. Neither call blocks beyond
/// `deadline`.
class Datagram {
 public:
  virtual ~Datagram() = default;
  /// One datagram, whole or not at all. Anything but ok: it was not taken, and is not kept.
  virtual Status send(Bytes data, const Peer& to) = 0;
  /// Bytes received and their sender; 0: none came.
  virtual Result<std::size_t> receive(Buffer buffer, Peer& from, Nanoseconds deadline) = 0;
  /// Datagrams without a single byte since the start: receive() does not return for them.
  virtual std::uint32_t empty_ones() const { return 0; }
};

}  // namespace sanso::board
