// Small robots for the tests of the diagnosis: text of URDF and model.toml, and recordings made
// from a command.
#pragma once

#include <cmath>
#include <functional>
#include <string>

#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/diagnose/sim/simulator.h"

namespace sanso::diagnose::test {

/// Point mass 0.5 kg at 0.1 m below a horizontal axis; q = 0 hangs down.
inline constexpr const char* kPendulumUrdf = R"(<robot name="pendulum"><link name="base"/>
<joint name="a" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
</joint>
<link name="arm"><inertial><origin xyz="0 0 -0.1"/><mass value="0.5"/>
<inertia ixx="1e-6" ixy="0" ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/></inertial></link></robot>)";

/// Two links in a plane plus a slider at the tip: every kind of joint, off-axis masses, a turned
/// frame.
inline constexpr const char* kArmUrdf = R"(<robot name="arm"><link name="base"/>
<joint name="a" type="continuous"><parent link="base"/><child link="upper"/>
<origin xyz="0 0 0.1" rpy="0.3 0 0.2"/><axis xyz="0 1 0"/></joint>
<link name="upper"><inertial><origin xyz="0.02 0.01 -0.15" rpy="0.1 0.2 0.3"/><mass value="0.8"/>
<inertia ixx="0.01" ixy="0.001" ixz="0" iyy="0.012" iyz="0" izz="0.003"/></inertial></link>
<joint name="b" type="continuous"><parent link="upper"/><child link="lower"/>
<origin xyz="0 0.05 -0.3" rpy="0 0.1 0.4"/><axis xyz="0.6 0.8 0"/></joint>
<link name="lower"><inertial><origin xyz="0 0.03 -0.2"/><mass value="0.5"/>
<inertia ixx="0.006" ixy="0" ixz="0.0005" iyy="0.005" iyz="0" izz="0.002"/></inertial></link>
<joint name="c" type="prismatic"><parent link="lower"/><child link="rod"/><origin xyz="0 0 -0.3"/>
<axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="10" velocity="2"/></joint>
<link name="rod"><inertial><origin xyz="0.04 0 -0.05"/><mass value="0.2"/>
<inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.0002"/></inertial></link></robot>)";

inline ModelFolder pendulum(const std::string& joint_default) {
  return parse_model("format = 1\n[joint_default]\n" + joint_default, kPendulumUrdf,
                     "pendulum/model.toml");
}
inline ModelFolder arm(const std::string& joint_default) {
  return parse_model("format = 1\n[joint_default]\n" + joint_default, kArmUrdf, "arm/model.toml");
}

/// A drive with equal time steps whose joints follow command(joint, t); measured positions are
/// zero.
inline Drive make_test_drive(const ModelFolder& model, double duration, double period,
                             const std::function<double(int, double)>& command) {
  Drive drive;
  drive.name = "made";
  const auto rows = static_cast<std::size_t>(std::lround(duration / period)) + 1;
  for (std::size_t k = 0; k < rows; ++k) drive.t.push_back(static_cast<double>(k) * period);
  for (int j = 0; j < model.tree.size(); ++j) {
    JointData data;
    data.q.assign(rows, 0.0);
    for (double t : drive.t) data.command.push_back(command(j, t));
    drive.joints.push_back(data);
  }
  return drive;
}

inline Window whole(const Drive& drive, std::vector<double> q, std::vector<double> dq) {
  return {0, drive.rows() - 1, std::move(q), std::move(dq)};
}

}  // namespace sanso::diagnose::test
