// A HID sensor through /dev/hidrawN: plain reads, no library that allocates. Devices with a sensor
// collection need the kernel's sensor hub kept away; docs/howto/robot.md says how.
#pragma once

#include <array>
#include <string>

#include "firmware/board/board.h"

namespace sanso::board {

class LinuxHidraw : public HidSource {
 public:
  explicit LinuxHidraw(std::string path) : path_(std::move(path)) {}
  ~LinuxHidraw() override;
  LinuxHidraw(const LinuxHidraw&) = delete;
  LinuxHidraw& operator=(const LinuxHidraw&) = delete;

  Status open(std::string& message);
  Bytes descriptor() override { return {descriptor_bytes_.data(), descriptor_size_}; }
  Status set_feature(Bytes report) override;
  Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) override;

 private:
  std::string path_;
  int file_ = -1;
  std::array<std::uint8_t, 4096> descriptor_bytes_{};
  std::size_t descriptor_size_ = 0;
};

}  // namespace sanso::board
