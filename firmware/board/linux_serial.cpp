// System calls of a tty: speed, raw mode and latency at open; a read returns when bytes have
// come or the deadline has passed.
#include "firmware/board/linux_serial.h"

// asm/termbits.h has termios2 (any speed) and must not meet termios.h
#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "firmware/board/linux_clock.h"

namespace sanso::board {

LinuxSerial::~LinuxSerial() { close(); }

void LinuxSerial::close() {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
}

Status LinuxSerial::open(std::string& message) {
  close();
  warning_.clear();
  descriptor_ = ::open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor_ < 0) {
    message = path_ + ": " + std::strerror(errno);
    if (errno == EACCES) message += "; add the user to the group dialout";
    if (errno == EBUSY)
      message += "; another program holds the bus, stop it first (on an OP3: the OP3-demo service)";
    return Status::io_error;
  }
  // two masters on one bus destroy each other's packets
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0 || ioctl(descriptor_, TIOCEXCL) != 0) {
    message =
        path_ + ": in use by another program; stop it first (on an OP3: the OP3-demo service)";
    close();
    return Status::io_error;
  }
  if (!configure(message)) {
    close();
    return Status::io_error;
  }
  ask_low_latency();
  message = warning_;
  return Status::ok;
}

bool LinuxSerial::configure(std::string& message) {
  termios2 t{};
  if (ioctl(descriptor_, TCGETS2, &t) != 0) {
    message = path_ + ": not a serial device";
    return false;
  }
  t.c_iflag = 0;
  t.c_oflag = 0;
  t.c_lflag = 0;
  t.c_cflag = CS8 | CREAD | CLOCAL | BOTHER | (BOTHER << IBSHIFT);
  t.c_ispeed = t.c_ospeed = static_cast<speed_t>(baud_);
  t.c_cc[VMIN] = 0;
  t.c_cc[VTIME] = 0;
  if (ioctl(descriptor_, TCSETS2, &t) != 0) {
    message = path_ + ": cannot set " + std::to_string(baud_) + " baud: " + std::strerror(errno);
    return false;
  }
  termios2 back{};
  if (ioctl(descriptor_, TCGETS2, &back) == 0 && back.c_ospeed != t.c_ospeed)
    warning_ = path_ + ": asked for " + std::to_string(baud_) + " baud, got " +
               std::to_string(back.c_ospeed);
  ioctl(descriptor_, TCFLSH, TCIOFLUSH);
  return true;
}

void LinuxSerial::ask_low_latency() {
  // On FTDI adapters this flag sets the latency timer to 1 ms; its default of 16 ms is longer than
  // a tick.
  serial_struct s{};
  if (ioctl(descriptor_, TIOCGSERIAL, &s) != 0) return;  // a pty or a driver without the notion
  s.flags |= ASYNC_LOW_LATENCY;
  if (ioctl(descriptor_, TIOCSSERIAL, &s) == 0 && ioctl(descriptor_, TIOCGSERIAL, &s) == 0 &&
      (s.flags & ASYNC_LOW_LATENCY) != 0)
    return;
  warning_ =
      path_ +
      ": the driver did not grant low latency; with an FTDI adapter replies may take 16 ms (write "
      "1 to "
      "/sys/bus/usb-serial/devices/<tty>/latency_timer)";
}

Status LinuxSerial::write(Bytes data) {
  if (descriptor_ < 0) return Status::io_error;
  std::size_t sent = 0;
  while (sent < data.size()) {
    const ssize_t n = ::write(descriptor_, data.data() + sent, data.size() - sent);
    if (n > 0) {
      sent += static_cast<std::size_t>(n);
    } else if (n < 0 && errno == EINTR) {
      continue;
    } else {
      return n < 0 && errno == EAGAIN ? Status::full : Status::io_error;
    }
  }
  return Status::ok;
}

Result<std::size_t> LinuxSerial::read(Buffer buffer, Nanoseconds deadline) {
  if (descriptor_ < 0) return Status::io_error;
  for (;;) {
    const ssize_t n = ::read(descriptor_, buffer.data(), buffer.size());
    if (n > 0) return static_cast<std::size_t>(n);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno != EAGAIN) return Status::io_error;
    // raw mode without data reads as 0 or EAGAIN; only poll tells "nothing yet" from "gone"
    const int ready = wait_readable(descriptor_, deadline);
    if (ready < 0) return Status::io_error;
    if (ready == 0) return std::size_t{0};
    if (n == 0 && ready == 1) {
      // readable and yet at the end: the other side of a pty has gone
      const ssize_t again = ::read(descriptor_, buffer.data(), buffer.size());
      if (again > 0) return static_cast<std::size_t>(again);
      if (again < 0 && (errno == EAGAIN || errno == EINTR)) continue;
      return Status::io_error;
    }
  }
}

}  // namespace sanso::board
