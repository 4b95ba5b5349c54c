// What the IMU and the pose source deliver, in SI units and base axes.
#pragma once

#include "shared/base/time.h"
#include "shared/math/so3.h"

namespace sanso::firmware {

inline constexpr double kGravity = 9.81;             // m/s^2, where the robot stands
inline constexpr double kStandardGravity = 9.80665;  // m/s^2: the g in which sensors count

struct ImuSample {
  Nanoseconds time = 0;        // arrival; 0: never
  std::uint32_t sequence = 0;  // counts complete samples
  // counts samples that differ from the one before: stands still when the sensor is frozen
  std::uint32_t changes = 0;
  math::Quat quat_world_base = math::quat_identity();
  math::Vec3 gyro = math::Vec3::Zero();   // w_base_in_base  rad/s
  math::Vec3 accel = math::Vec3::Zero();  // specific force, base axes (+9.81 on z at rest)  m/s^2
};

struct PoseSample {
  // when the pose was true (arrival minus the age it states); 0: never
  Nanoseconds time = 0;
  std::uint32_t sequence = 0;
  std::uint8_t confidence = 0;                   // 0 (lost) .. 3
  math::Vec3 p_track_base = math::Vec3::Zero();  // m, in the tracker's own frame (z up)
  math::Quat quat_track_base = math::quat_identity();
  math::Vec3 v_base_in_track = math::Vec3::Zero();  // m/s
};

}  // namespace sanso::firmware
