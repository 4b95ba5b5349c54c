// The servo bus on a Linux tty: any speed (termios2), exclusive, raw, low latency where the driver
// knows it. A pty works too; it paces nothing and knows none of the optional calls.
#pragma once

#include <string>

#include "firmware/board/reconnect.h"

namespace sanso::board {

class LinuxSerial : public OpenableSerial {
 public:
  LinuxSerial(std::string path, int baud) : path_(std::move(path)), baud_(baud) {}
  ~LinuxSerial() override;
  LinuxSerial(const LinuxSerial&) = delete;
  LinuxSerial& operator=(const LinuxSerial&) = delete;

  /// Opens the device. io_error: `message` says what failed and what to do about it; ok: it says
  /// what the driver did not grant, if anything.
  Status open(std::string& message) override;

  Status write(Bytes data) override;
  Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) override;
  Status ready() override { return descriptor_ >= 0 ? Status::ok : Status::not_ready; }

 private:
  void close();
  bool configure(std::string& message);
  void ask_low_latency();

  std::string path_;
  int baud_;
  int descriptor_ = -1;
  std::string warning_;
};

}  // namespace sanso::board
