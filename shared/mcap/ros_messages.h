// The two ROS 2 messages that recordings are made of, and their CDR encoding (little-endian, plain
// CDR version 1).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace sanso::mcap {

inline constexpr std::string_view kJointStateType = "sensor_msgs/msg/JointState";
inline constexpr std::string_view kImuType = "sensor_msgs/msg/Imu";

/// sensor_msgs/msg/JointState. Arrays may be shorter than `name`: not sampled.
struct JointState {
  double stamp_s = 0.0;
  std::vector<std::string> name;
  std::vector<double> position, velocity, effort;
};

/// sensor_msgs/msg/Imu, without its covariances.
struct Imu {
  double stamp_s = 0.0;
  std::array<double, 4> orientation{1, 0, 0, 0};  // w x y z
  std::array<double, 3> angular_velocity{};       // rad/s, sensor axes
  std::array<double, 3> linear_acceleration{};    // m/s^2, sensor axes
};

/// Nothing when the bytes are not such a message.
std::optional<JointState> decode_joint_state(std::string_view cdr);
std::optional<Imu> decode_imu(std::string_view cdr);
std::string encode(const JointState& message);
std::string encode(const Imu& message);

/// Message definition as MCAP's schema record wants it.
std::string_view joint_state_definition();
std::string_view imu_definition();

}  // namespace sanso::mcap
