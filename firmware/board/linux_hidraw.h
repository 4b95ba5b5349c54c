// A HID sensor through /dev/hidrawN: plain reads, no library that allocates. Devices with a sensor
// collection need the kernel's sensor hub kept away; docs/howto/robot.md says how.
#pragma once

#include <array>
#include <string>

#include "firmware/board/hid_names.h"
#include "firmware/board/reconnect.h"

namespace sanso::board {

class LinuxHidraw : public OpenableHid {
 public:
  explicit LinuxHidraw(std::string path) : path_(std::move(path)) {}
  /// By vendor, product and serial number, whatever its number is when it is opened.
  explicit LinuxHidraw(DeviceSelector wanted) : wanted_(std::move(wanted)) {}
  ~LinuxHidraw() override;
  LinuxHidraw(const LinuxHidraw&) = delete;
  LinuxHidraw& operator=(const LinuxHidraw&) = delete;

  Status open(std::string& message) override;
  Bytes descriptor() override { return {descriptor_bytes_.data(), descriptor_size_}; }
  HidIdentity identity() override { return identity_; }
  Status set_feature(Bytes report) override;
  Result<std::size_t> get_feature(Buffer report) override;
  Result<std::size_t> read(Buffer buffer, Nanoseconds deadline) override;

 private:
  bool find(std::string& message);

  std::string path_;
  std::optional<DeviceSelector> wanted_;
  int file_ = -1;
  std::array<std::uint8_t, 4096> descriptor_bytes_{};
  std::size_t descriptor_size_ = 0;
  HidIdentity identity_;
};

}  // namespace sanso::board
