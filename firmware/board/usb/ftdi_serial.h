// The servo bus on an FTDI chip without a tty: a thread of its own keeps several bulk reads in
// flight and hands bytes over through a ring, so that the tick only copies and polls a descriptor;
// nothing of a USB library, which allocates with every transfer, runs in the tick's thread.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "firmware/board/reconnect.h"
#include "firmware/board/usb/usb_line.h"

namespace sanso::board {

/// Bytes from one thread to another; a full ring drops what does not fit and says so.
class ByteRing {
 public:
  /// Bytes taken.
  std::size_t push(Bytes data);
  std::size_t pop(Buffer out);

 private:
  static constexpr std::size_t kCapacity = 8192;
  std::array<std::uint8_t, kCapacity> bytes_{};
  std::atomic<std::size_t> head_{0}, tail_{0};
};

class FtdiSerial final : public OpenableSerial {
 public:
  struct Counters {
    std::atomic<std::uint32_t> line_errors{0};  // packets with framing, parity or overrun
    std::atomic<std::uint32_t> stalls{0};
    std::atomic<std::uint32_t> dropped{0};  // bytes that nobody fetched
  };

  /// `wanted`: vendor and product, and the serial number unless it is empty. `priority`: SCHED_FIFO
  /// of the transfer thread, 0: ordinary.
  FtdiSerial(UsbLibrary& library, UsbIdentity wanted, int baud, int priority);
  ~FtdiSerial() override;
  FtdiSerial(const FtdiSerial&) = delete;
  FtdiSerial& operator=(const FtdiSerial&) = delete;

  /// Opens, resets, sets bit rate, 8N1, no flow control and a latency timer of 1 ms, which is read
  /// back: io_error when the chip keeps another.
  Status open(std::string& message) override;
  /// full: the bytes before have not left yet.
  Status write(Bytes data) override;
  Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) override;
  Status ready() override { return gone_ ? Status::not_ready : Status::ok; }
  const Counters& counters() const { return counters_; }

 private:
  void close();
  bool configure(std::string& message);
  void run();
  bool start_reads();
  bool take(const UsbEvent& event);
  bool take_read(const UsbEvent& event);
  bool send();
  void tell_reader() const;

  UsbLibrary& library_;
  UsbIdentity wanted_;
  int baud_, priority_;
  std::unique_ptr<UsbLine> line_;
  std::thread thread_;
  std::atomic<bool> stop_{false}, gone_{true};
  int event_ = -1;  // readable when the input ring has got something, or the device has gone
  ByteRing in_, out_;
  Counters counters_;

  // the transfer thread's
  std::array<std::array<std::uint8_t, 512>, UsbLine::kReads> buffers_{};
  std::array<std::uint8_t, 4096> writing_{};
  std::size_t to_write_ = 0, written_ = 0;
  bool write_busy_ = false;
  int failures_in_a_row_ = 0;
};

}  // namespace sanso::board
