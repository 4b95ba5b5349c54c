// System calls of a HID device: descriptor at start (may block), then reads against a deadline
// and feature reports.
#include "firmware/board/linux_hidraw.h"

#include <fcntl.h>
#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "firmware/board/linux_clock.h"

namespace sanso::board {

LinuxHidraw::~LinuxHidraw() {
  if (file_ >= 0) ::close(file_);
}

Status LinuxHidraw::open(std::string& message) {
  if (file_ >= 0) ::close(file_);
  descriptor_size_ = 0;
  identity_ = {};
  file_ = -1;
  if (wanted_ && !find(message)) return Status::io_error;
  file_ = ::open(path_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (file_ < 0) {
    message = path_ + ": " + std::strerror(errno);
    if (errno == EACCES) message += "; a udev rule has to give this user the device";
    if (errno == ENOENT)
      message += "; is the sensor plugged in, and hid-sensor-hub kept from claiming it?";
    return Status::io_error;
  }
  int size = 0;
  hidraw_report_descriptor report{};
  if (ioctl(file_, HIDIOCGRDESCSIZE, &size) != 0) {
    message = path_ + ": not a hidraw device";
    return Status::io_error;
  }
  report.size = static_cast<__u32>(size);
  if (ioctl(file_, HIDIOCGRDESC, &report) != 0) {
    message = path_ + ": cannot read the report descriptor: " + std::strerror(errno);
    return Status::io_error;
  }
  descriptor_size_ =
      std::min<std::size_t>(static_cast<std::size_t>(size), descriptor_bytes_.size());
  std::copy_n(report.value, descriptor_size_, descriptor_bytes_.begin());
  hidraw_devinfo info{};
  if (ioctl(file_, HIDIOCGRAWINFO, &info) == 0)
    identity_ = {static_cast<std::uint16_t>(info.vendor), static_cast<std::uint16_t>(info.product)};
  return Status::ok;
}

bool LinuxHidraw::find(std::string& message) {
  for (const HidName& name : hid_names()) {
    const bool same = name.identity.vendor == wanted_->identity.vendor &&
                      name.identity.product == wanted_->identity.product &&
                      (wanted_->serial.empty() || name.serial == wanted_->serial);
    if (!same) continue;
    path_ = "/dev/" + name.node;
    return true;
  }
  message = "HID device " + HidName{{}, wanted_->identity, wanted_->serial, {}}.selector() +
            ": not plugged in, or claimed by hid-sensor-hub (then use hidapi-libusb:)";
  return false;
}

Status LinuxHidraw::set_feature(Bytes report) {
  if (file_ < 0 || report.size() > 256) return Status::io_error;
  std::array<std::uint8_t, 256> copy{};
  std::copy(report.begin(), report.end(), copy.begin());
  return ioctl(file_, HIDIOCSFEATURE(report.size()), copy.data()) >= 0 ? Status::ok
                                                                       : Status::io_error;
}

Result<std::size_t> LinuxHidraw::get_feature(Buffer report) {
  if (file_ < 0 || report.empty() || report.size() > 256) return Status::io_error;
  const int n = ioctl(file_, HIDIOCGFEATURE(report.size()), report.data());
  if (n < 0) return Status::io_error;
  return static_cast<std::size_t>(n);
}

Result<std::size_t> LinuxHidraw::read(Buffer buffer, Nanoseconds deadline) {
  if (file_ < 0) return Status::io_error;
  for (;;) {
    const ssize_t n = ::read(file_, buffer.data(), buffer.size());
    if (n > 0) return static_cast<std::size_t>(n);
    if (n < 0 && errno == EINTR) continue;
    if (n == 0 || errno != EAGAIN) return Status::io_error;
    const int ready = wait_readable(file_, deadline);
    if (ready < 0) return Status::io_error;
    if (ready == 0) return std::size_t{0};
  }
}

}  // namespace sanso::board
