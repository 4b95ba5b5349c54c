// MicroStrain's MIP packets from a stream of bytes: accelerations, rates and the quaternion of a
// 3DM-GX5. Fixed memory. Source: 3DM-GX5-25 Data Communications Protocol Manual.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "shared/base/fixed_vector.h"
#include "shared/math/so3.h"

namespace sanso::firmware {

/// What one data packet held, in SI units. The sensor's own frames: navigation frame north-east-
/// down, body axes x forward, y right, z down.
struct MipSample {
  std::optional<math::Vec3> accel;  // specific force m/s^2
  std::optional<math::Vec3> gyro;   // rad/s
  std::optional<math::Quat> quat;   // navigation frame to body, as the device sends it
};

class MipParser {
 public:
  /// Takes bytes; calls `sample` for every good data packet.
  template <class OnSample>
  void feed(std::span<const std::uint8_t> bytes, OnSample&& sample) {
    for (const std::uint8_t byte : bytes) {
      if (!buffer_.try_push(byte)) buffer_.clear();
      while (cut_packet()) {
        if (packet_is_data()) sample(decode());
        drop(packet_size());
      }
    }
  }
  std::uint32_t bad_packets() const { return bad_packets_; }

 private:
  static constexpr std::size_t kHeader = 4, kChecksum = 2;
  std::size_t packet_size() const { return kHeader + buffer_[3] + kChecksum; }
  bool packet_is_data() const;
  bool cut_packet();  // a whole, good packet stands at the front
  void drop(std::size_t count);
  MipSample decode() const;

  FixedVector<std::uint8_t, 512> buffer_;
  std::uint32_t bad_packets_ = 0;
};

/// 75 65, descriptor set, length, payload, checksum; bytes used, 0: `out` is too small.
std::size_t make_mip_packet(std::uint8_t descriptor_set, std::span<const std::uint8_t> payload,
                            std::span<std::uint8_t> out);

}  // namespace sanso::firmware
