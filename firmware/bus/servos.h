// The twenty servos: slots 0..11 are the leg joints in joint order, 12..19 arms and head, which the
// controller holds in the maker's walkready pose (action page 9; head level).
#pragma once

#include <array>
#include <cstdint>

#include "shared/model/joints.h"

namespace sanso::firmware {

struct HeldServo {
  const char* name;
  std::uint8_t servo_id;
  double pose_rad;
};

inline constexpr double kRadPerDeg = model::kPi / 180.0;

inline constexpr std::array<HeldServo, 8> kHeldServos{{
    {"r_sho_pitch", 1, 4.92 * kRadPerDeg},
    {"l_sho_pitch", 2, -5.01 * kRadPerDeg},
    {"r_sho_roll", 3, -45.62 * kRadPerDeg},
    {"l_sho_roll", 4, 45.35 * kRadPerDeg},
    {"r_el", 5, 45.18 * kRadPerDeg},
    {"l_el", 6, -45.35 * kRadPerDeg},
    {"head_pan", 19, 0.0},
    {"head_tilt", 20, 0.0},
}};

/// A joint farther outside its range [rad] was misread, or is no joint of this robot.
inline constexpr double kFarOutside_rad = 0.6;

/// Arms and head turn this far either way [rad].
inline constexpr double kHeldRange_rad = 0.9 * model::kPi;

inline constexpr int kNumHeld = static_cast<int>(kHeldServos.size());
inline constexpr int kNumServos = model::kNumJoints + kNumHeld;

constexpr std::array<std::uint8_t, kNumServos> make_servo_ids() {
  std::array<std::uint8_t, kNumServos> ids{};
  for (std::size_t j = 0; j < model::kNumJoints; ++j) ids[j] = model::kJoints[j].servo_id;
  for (std::size_t k = 0; k < kNumHeld; ++k) ids[model::kNumJoints + k] = kHeldServos[k].servo_id;
  return ids;
}
/// Servo id of a slot.
inline constexpr std::array<std::uint8_t, kNumServos> kServoIds = make_servo_ids();

/// Slot of a servo id, -1 when it is none of ours.
constexpr int slot_of(std::uint8_t id) {
  for (int s = 0; s < kNumServos; ++s)
    if (kServoIds[static_cast<std::size_t>(s)] == id) return s;
  return -1;
}

constexpr const char* servo_name(int slot) {
  return slot < model::kNumJoints
             ? model::kJoints[static_cast<std::size_t>(slot)].name
             : kHeldServos[static_cast<std::size_t>(slot - model::kNumJoints)].name;
}

}  // namespace sanso::firmware
