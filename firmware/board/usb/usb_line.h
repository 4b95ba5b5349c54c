// The few calls of a USB library that the FTDI driver needs, of one opened device: control
// transfers that block, and bulk transfers that run on their own. libusb stands behind it on the
// robot (libusb_line.h), a model of the chip in tests. One thread uses it; only wake() may come
// from another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "firmware/board/board.h"

namespace sanso::board {

struct UsbIdentity {
  std::uint16_t vendor = 0, product = 0;
  std::string serial;
  std::uint16_t release = 0;  // bcdDevice: which chip
};

/// How a bulk transfer ended.
struct UsbEvent {
  enum class Kind : std::uint8_t { none, read, write };
  enum class Outcome : std::uint8_t { done, stalled, gone };
  Kind kind = Kind::none;
  Outcome outcome = Outcome::done;
  int slot = 0;           // of the read
  std::size_t bytes = 0;  // moved
};

class UsbLine {
 public:
  static constexpr int kReads = 4;  // bulk reads in flight
  virtual ~UsbLine() = default;

  virtual const UsbIdentity& identity() const = 0;
  /// Largest packet of the bulk input, bytes.
  virtual std::size_t packet_bytes() const = 0;
  /// Vendor requests. io_error: refused or gone.
  virtual Status control_out(std::uint8_t request, std::uint16_t value, std::uint16_t index) = 0;
  virtual Result<std::size_t> control_in(std::uint8_t request, std::uint16_t value,
                                         std::uint16_t index, Buffer data) = 0;
  /// Starts the read of `slot` into `buffer`, which stays the device's until its event.
  virtual Status submit_read(int slot, Buffer buffer) = 0;
  /// Starts a write; one at a time. `data` stays the device's until its event.
  virtual Status submit_write(Bytes data) = 0;
  /// The next end of a transfer; waits `timeout_ms` at most and returns earlier after wake().
  /// Kind none: nothing ended.
  virtual UsbEvent wait(int timeout_ms) = 0;
  /// Ends a stall of the bulk input or output.
  virtual Status clear_stall(UsbEvent::Kind which) = 0;
  virtual void wake() = 0;
};

/// Finds and opens a device. `serial` empty: any. Null: `message` says why.
class UsbLibrary {
 public:
  virtual ~UsbLibrary() = default;
  virtual std::unique_ptr<UsbLine> open(const UsbIdentity& wanted, std::string& message) = 0;
};

}  // namespace sanso::board
