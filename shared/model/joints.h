// The twelve controlled joints: order, names, servo ids and limits. Declared here and nowhere else.
// Figures: ROBOTIS OP3 URDF (names, signs), ROBOTIS OP3 device file (ids), ROBOTIS OP3 kinematics
// (limits x pi rad).
#pragma once

#include <array>
#include <cstdint>

#include "shared/model/state_layout.h"

namespace sanso::model {

struct JointInfo {
  const char* name;
  std::uint8_t servo_id;
  double lower_rad;
  double upper_rad;
};

inline constexpr double kPi = 3.14159265358979323846;

inline constexpr std::array<JointInfo, kNumJoints> kJoints{{
    {"r_hip_yaw", 7, -0.45 * kPi, 0.45 * kPi},
    {"r_hip_roll", 9, -0.30 * kPi, 0.30 * kPi},
    {"r_hip_pitch", 11, -0.40 * kPi, 0.40 * kPi},
    {"r_knee", 13, -0.70 * kPi, 0.10 * kPi},
    {"r_ank_pitch", 15, -0.45 * kPi, 0.45 * kPi},
    {"r_ank_roll", 17, -0.45 * kPi, 0.45 * kPi},
    {"l_hip_yaw", 8, -0.45 * kPi, 0.45 * kPi},
    {"l_hip_roll", 10, -0.30 * kPi, 0.30 * kPi},
    {"l_hip_pitch", 12, -0.40 * kPi, 0.40 * kPi},
    {"l_knee", 14, -0.10 * kPi, 0.70 * kPi},
    {"l_ank_pitch", 16, -0.45 * kPi, 0.45 * kPi},
    {"l_ank_roll", 18, -0.45 * kPi, 0.45 * kPi},
}};

/// Position gain register of the XM430: 70 % of its default 800 (paper, "Hardware details").
inline constexpr int kPositionPGainRaw = 560;

}  // namespace sanso::model
