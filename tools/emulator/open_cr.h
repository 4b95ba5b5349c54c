// The OpenCR board as a bus device: switches the servos' supply, shows buttons, voltage and its own
// coarse IMU.
#pragma once

#include <array>

#include "shared/servo_bus/opencr.h"
#include "tools/emulator/bus_device.h"
#include "tools/plant/random.h"
#include "tools/plant/vec.h"

namespace sanso::emulator {

class OpenCr final : public BusDevice {
 public:
  explicit OpenCr(std::uint64_t seed) : random_(seed) {}
  bool servo_power() const { return bytes_[servo_bus::opencr::kServoPower] != 0; }
  /// Bits kButtonMode, kButtonStart, kButtonUser; until the next call.
  void press(std::uint8_t buttons);
  /// What its register shows, in steps of 0.1 V.
  void set_voltage(double volt);
  /// Specific force [m/s^2] and rate [rad/s] in base axes; the board lies turned by half a turn
  /// about z, so that its x and y count the other way. Its tilt comes from the accelerometer alone.
  void set_imu(const plant::Vec3& specific_force, const plant::Vec3& rate);

  std::uint8_t id() const override { return servo_bus::opencr::kId; }
  std::uint16_t model() const override { return servo_bus::opencr::kModel; }
  std::uint8_t firmware() const override { return 1; }
  bool listening() const override { return true; }
  Nanoseconds return_delay() const override { return 40 * kMicrosecond; }
  int status_return_level() const override { return 2; }
  bool alert() const override { return false; }
  servo_bus::StatusError read(std::uint16_t address, std::span<std::uint8_t> out) const override;
  servo_bus::StatusError write(std::uint16_t address, std::span<const std::uint8_t> data,
                               Nanoseconds now) override;
  void reboot(Nanoseconds) override { bytes_.fill(0); }
  void heard(Nanoseconds) override {}
  void hold_write(HeldWrite write) override { held_ = std::move(write); }
  servo_bus::StatusError run_held_write(Nanoseconds now) override {
    return write(held_.address, held_.data, now);
  }

 private:
  std::array<std::uint8_t, servo_bus::opencr::kTableBytes> bytes_{};
  HeldWrite held_;
  plant::Vec3 smooth_force_{0, 0, 9.81};
  plant::Random random_;
};

}  // namespace sanso::emulator
