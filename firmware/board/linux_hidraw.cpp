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
  return Status::ok;
}

Status LinuxHidraw::set_feature(Bytes report) {
  if (file_ < 0 || report.size() > 256) return Status::io_error;
  std::array<std::uint8_t, 256> copy{};
  std::copy(report.begin(), report.end(), copy.begin());
  return ioctl(file_, HIDIOCSFEATURE(report.size()), copy.data()) >= 0 ? Status::ok
                                                                       : Status::io_error;
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
