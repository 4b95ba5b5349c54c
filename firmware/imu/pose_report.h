// Bytes of one pose sample, little-endian, 48 bytes:
//   0  u8   report id 0x50
//   1  u8   confidence, 0 (lost) .. 3
//   2  u16  age when sent, 0.1 ms
//   4  f32 x 3  p_track_base  m          tracker's frame: z up
//  16  f32 x 4  quat_track_base  w x y z
//  32  f32 x 3  v_base_in_track  m/s
//  44  u32  sequence number
// A bridge between the camera's own driver and the controller sends these; the emulator does the same.
#pragma once

#include <span>

#include "firmware/imu/samples.h"
#include "shared/base/status.h"

namespace sanso::firmware {

inline constexpr std::size_t kPoseReportBytes = 48;
inline constexpr std::uint8_t kPoseReportId = 0x50;

/// ok, or malformed: wrong length or id, a number that is not finite, a quaternion that is none. `out` changes only when ok.
Status parse_pose_report(std::span<const std::uint8_t> bytes, Nanoseconds arrival, PoseSample& out);

}  // namespace sanso::firmware
