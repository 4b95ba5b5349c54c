// The board's registers, and what a write to them does.
#include "tools/emulator/open_cr.h"

#include <algorithm>
#include <cmath>

namespace sanso::emulator {

namespace reg = servo_bus::opencr;
using servo_bus::StatusError;

namespace {

// of the class of sensor on the board, over the 100 Hz at which it is read
constexpr double kGyroNoise_deg_s = 0.1, kAccelNoise_g = 0.003;

}  // namespace

void OpenCr::press(std::uint8_t buttons) {
  bytes_[reg::kButtons] = buttons;
  // the board cuts the servos' supply by itself
  if (buttons & reg::kButtonReset) bytes_[reg::kServoPower] = 0;
}

void OpenCr::set_voltage(double volt) {
  bytes_[reg::kVoltage] = static_cast<std::uint8_t>(std::clamp(std::lround(volt * 10), 0l, 255l));
}

void OpenCr::set_imu(const plant::Vec3& force_base, const plant::Vec3& rate_base) {
  const plant::Vec3 specific_force{-force_base[0], -force_base[1], force_base[2]};
  const plant::Vec3 rate{-rate_base[0], -rate_base[1], rate_base[2]};
  const auto put = [&](std::uint16_t address, double counts) {
    servo_bus::put_le(&bytes_[address], 2, std::clamp(std::lround(counts), -32768l, 32767l));
  };
  constexpr double kDeg = 180.0 / plant::kPi;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto offset = static_cast<std::uint16_t>(2 * i);
    put(reg::kGyro + offset,
        (rate[i] * kDeg + kGyroNoise_deg_s * random_.normal()) * reg::kGyroCountsPerDegPerSecond);
    put(reg::kAccelerometer + offset,
        (specific_force[i] / 9.80665 + kAccelNoise_g * random_.normal()) * reg::kAccelCountsPerG);
    smooth_force_[i] += 0.4 * (specific_force[i] - smooth_force_[i]);  // the maker's low-pass
  }
  const auto& f = smooth_force_;
  put(reg::kRollPitchYaw, 10 * kDeg * std::atan2(f[1], f[2]));
  put(reg::kRollPitchYaw + 2, 10 * kDeg * std::atan2(-f[0], std::hypot(f[1], f[2])));
  put(reg::kRollPitchYaw + 4, 0);
}

StatusError OpenCr::read(std::uint16_t address, std::span<std::uint8_t> out) const {
  if (out.empty() || address + out.size() > bytes_.size()) return StatusError::data_range;
  std::copy_n(bytes_.begin() + address, out.size(), out.begin());
  return StatusError::none;
}

StatusError OpenCr::write(std::uint16_t address, std::span<const std::uint8_t> data, Nanoseconds) {
  if (data.empty()) return StatusError::data_length;
  if (address + data.size() > bytes_.size()) return StatusError::data_range;
  const bool writable = (address >= reg::kServoPower && address + data.size() <= reg::kButtons) ||
                        (address == reg::kImuControl && data.size() == 1);
  if (!writable) return StatusError::access;
  std::copy(data.begin(), data.end(), bytes_.begin() + address);
  return StatusError::none;
}

}  // namespace sanso::emulator
