// Recordings as MCAP files with ROS 2 messages: what `ros2 bag` of any robot writes, and
// PlotJuggler and Foxglove open.
//
//   topic                     message      becomes
//   /joint_states             JointState   q, dq, tau
//   a JointState topic with "command", "goal" or "target" in its name
//                             JointState   u (position), tau_cmd (effort); a position of NaN: the
//                             actuator is off
//   any topic                 Imu          base_q, base_w, imu_acc
//   /joint_currents /joint_duties /joint_temperatures /supply_voltage (ours)
//                             JointState   i, pwm, temp, volt (position)
#pragma once

#include <string>

#include "tools/recording/recording.h"

namespace sanso::recording {

/// Rows are the instants of /joint_states (message stamps). Other topics are held from their last
/// message. A file that was cut gives its complete rows (Recording::cut). Throws InputError.
Recording read_mcap(const std::string& path, std::size_t max_values = 100'000'000);

/// A recording of any kind, by the file's name: .mcap, .db3 (rosbag_db3.h), else CSV; with its
/// sidecar.
Recording read_recording(const std::string& path);

}  // namespace sanso::recording
