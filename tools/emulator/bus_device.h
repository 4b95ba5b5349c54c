// A device on the servo bus as the bus sees it: id, registers, timing. Servos and the OpenCR board
// are two of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "shared/base/time.h"
#include "shared/servo_bus/packet.h"

namespace sanso::emulator {

class BusDevice {
 public:
  virtual ~BusDevice() = default;

  virtual std::uint8_t id() const = 0;
  virtual std::uint16_t model() const = 0;
  virtual std::uint8_t firmware() const = 0;
  /// Understands the fast reads.
  virtual bool knows_fast_read() const { return true; }
  /// False: neither hears nor speaks (no power, rebooting, cable off).
  virtual bool listening() const = 0;
  /// From the last byte of an instruction to the first of the reply.
  virtual Nanoseconds return_delay() const = 0;
  /// 0 replies to ping only, 1 also to reads, 2 to everything.
  virtual int status_return_level() const = 0;
  /// Top bit of every status packet's error byte.
  virtual bool alert() const = 0;

  /// Bytes of the control table from `address` on; an error leaves `out` as it is.
  virtual servo_bus::StatusError read(std::uint16_t address, std::span<std::uint8_t> out) const = 0;
  /// All of it or, with an error, nothing.
  virtual servo_bus::StatusError write(std::uint16_t address, std::span<const std::uint8_t> data,
                                       Nanoseconds now) = 0;
  /// As the Reboot instruction does: volatile registers are the power-up values again.
  virtual void reboot(Nanoseconds now) = 0;
  /// An instruction for this device has arrived (feeds its bus watchdog).
  virtual void heard(Nanoseconds now) = 0;

  /// A write held until the Action instruction.
  struct HeldWrite {
    std::uint16_t address = 0;
    std::vector<std::uint8_t> data;
  };
  /// One is kept; a later one takes its place.
  virtual void hold_write(HeldWrite write) = 0;
  virtual servo_bus::StatusError run_held_write(Nanoseconds now) = 0;
};

}  // namespace sanso::emulator
