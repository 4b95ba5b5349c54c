// Where the emulated servo bus meets a client: a pty, or a USB adapter of the kernel's.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "shared/base/time.h"

namespace sanso::emulator {

class BusEnd {
 public:
  virtual ~BusEnd() = default;
  virtual void plug() = 0;     // throws plant::WorldError
  virtual void unplug() = 0;   // as if the cable were pulled
  virtual int fd() const = 0;  // for poll(); -1: unplugged
  /// How a person finds it.
  virtual std::string device() const = 0;
  virtual std::size_t read(std::span<std::uint8_t> out) = 0;
  virtual void write(std::span<const std::uint8_t> bytes) = 0;
  /// Speed that the client has set; 0: not known.
  virtual int baud() const = 0;
  /// Does what is due at this time of the robot; when there is something again.
  virtual Nanoseconds serve(Nanoseconds now) = 0;
};

}  // namespace sanso::emulator
