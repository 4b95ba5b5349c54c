// A sample of the tracking camera as bytes: position and velocity of the base from outside. Carried
// like a HID report (first byte = report id) between the pose source and the controller's board
// layer.
//
// Layout, 52 bytes, little-endian: id u8 = 0x40 | confidence u8 0..3 | 0 u16 | sequence u32 | age
// u32 us |
//   p_world_base 3 f32 m | quat_world_base wxyz 4 f32 | v_base_in_world 3 f32 m/s
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "shared/base/status.h"

namespace sanso {

inline constexpr std::uint8_t kPoseReportId = 0x40;
inline constexpr std::size_t kPoseReportBytes = 52;

struct PoseReport {
  std::uint8_t confidence = 0;  // 0 lost, 3 best
  std::uint32_t sequence = 0;   // counts samples; a gap is a lost one
  std::uint32_t age_us = 0;     // from the exposure to the sending of this report
  std::array<float, 3> p_world_base{};
  std::array<float, 4> quat_world_base{1, 0, 0, 0};
  std::array<float, 3> v_base_in_world{};
};

namespace detail {
constexpr void put_u32(std::uint8_t* out, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) out[i] = static_cast<std::uint8_t>(value >> (8 * i));
}
constexpr std::uint32_t take_u32(const std::uint8_t* in) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(in[i]) << (8 * i);
  return value;
}
}  // namespace detail

inline std::array<std::uint8_t, kPoseReportBytes> encode_pose_report(const PoseReport& report) {
  std::array<std::uint8_t, kPoseReportBytes> out{};
  out[0] = kPoseReportId;
  out[1] = report.confidence;
  detail::put_u32(&out[4], report.sequence);
  detail::put_u32(&out[8], report.age_us);
  std::size_t at = 12;
  const auto put = [&](float value) {
    detail::put_u32(&out[at], std::bit_cast<std::uint32_t>(value));
    at += 4;
  };
  for (const float value : report.p_world_base) put(value);
  for (const float value : report.quat_world_base) put(value);
  for (const float value : report.v_base_in_world) put(value);
  return out;
}

/// malformed: wrong size or id. out_of_range: a number that is not finite, or a quaternion that is
/// not unit.
inline Result<PoseReport> decode_pose_report(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kPoseReportBytes || bytes[0] != kPoseReportId) return Status::malformed;
  PoseReport report;
  report.confidence = bytes[1];
  report.sequence = detail::take_u32(&bytes[4]);
  report.age_us = detail::take_u32(&bytes[8]);
  std::size_t at = 12;
  bool finite = true;
  const auto take = [&](float& value) {
    value = std::bit_cast<float>(detail::take_u32(&bytes[at]));
    finite = finite && value > -1e6f && value < 1e6f;  // false for NaN too
    at += 4;
  };
  for (float& value : report.p_world_base) take(value);
  for (float& value : report.quat_world_base) take(value);
  for (float& value : report.v_base_in_world) take(value);
  float square = 0;
  for (const float value : report.quat_world_base) square += value * value;
  if (!finite || square < 0.99f || square > 1.01f || report.confidence > 3)
    return Status::out_of_range;
  return report;
}

}  // namespace sanso
