// The control table of one XM430 as bytes, with the rules of who may write what. What a write makes
// the servo do is not decided here.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "shared/base/fixed_vector.h"
#include "shared/servo_bus/xm430.h"

namespace sanso::emulator {

class RegisterFile {
 public:
  RegisterFile() { load_defaults(true); }

  /// Power-on values of the RAM area; with `eeprom` also the factory values of the EEPROM.
  void load_defaults(bool eeprom);

  /// Raw value, sign extended where the register has one.
  std::int64_t get(const servo_bus::Register& r) const;
  void set(const servo_bus::Register& r, std::int64_t value_raw);

  /// Through indirect entries too; an error when it ends beyond the table.
  servo_bus::StatusError read(std::uint16_t address, std::span<std::uint8_t> out) const;

  static constexpr std::size_t kMaxTouched = 64;
  using Touched = FixedVector<const servo_bus::Register*, kMaxTouched>;

  /// Checks a write completely (access, torque, range; through indirect entries too) and applies
  /// it, or nothing of it.
  /// `touched` lists the registers that were written.
  servo_bus::StatusError write(std::uint16_t address, std::span<const std::uint8_t> data,
                               Touched& touched);

 private:
  std::uint16_t resolve(std::uint16_t address) const;

  std::array<std::uint8_t, servo_bus::xm430::kTableBytes> bytes_{};
};

}  // namespace sanso::emulator
