// Small robots for the tests of the diagnosis: a pendulum, arms and a slider with known settings,
// worlds in which effects are hidden, and recordings of what such a world does. Settings are the
// lines of [joint_default]; nothing here draws a random number without a seed.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/sensor_noise.h"
#include "tools/diagnose/effects/from_model.h"
#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/diagnose/sim/simulator.h"
#include "tools/recording/recording.h"

namespace sanso::diagnose::test {

/// Point mass 0.5 kg at 0.1 m below a horizontal axis; q = 0 hangs down.
inline constexpr const char* kPendulumUrdf = R"(<robot name="pendulum"><link name="base"/>
<joint name="a" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>
</joint>
<link name="arm"><inertial><origin xyz="0 0 -0.1"/><mass value="0.5"/>
<inertia ixx="1e-6" ixy="0" ixz="0" iyy="1e-6" iyz="0" izz="1e-6"/></inertial></link></robot>)";

/// Two links in one plane, each a mass on a rod.
inline constexpr const char* kTwoLinksUrdf = R"(<robot name="two"><link name="base"/>
<joint name="a" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
</joint>
<link name="upper"><inertial><origin xyz="0 0 -0.15"/><mass value="0.6"/>
<inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.0001"/></inertial></link>
<joint name="b" type="continuous"><parent link="upper"/><child link="lower"/>
<origin xyz="0 0 -0.2"/><axis xyz="0 1 0"/></joint>
<link name="lower"><inertial><origin xyz="0 0 -0.2"/><mass value="0.5"/>
<inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.0001"/></inertial></link></robot>)";

/// A carriage of 0.8 kg on a rail that climbs a little, with its weight beside the rail.
inline constexpr const char* kSliderUrdf = R"(<robot name="slider"><link name="base"/>
<joint name="s" type="prismatic"><parent link="base"/><child link="carriage"/>
<origin xyz="0 0 0.2" rpy="0 0.3 0"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="10" velocity="2"/></joint>
<link name="carriage"><inertial><origin xyz="0.02 0.03 -0.05"/><mass value="0.8"/>
<inertia ixx="0.002" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.001"/></inertial></link></robot>)";

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

inline ModelFolder small_model(const std::string& joint_default, const char* urdf,
                               const std::string& name) {
  return parse_model("format = 1\n[joint_default]\n" + joint_default, urdf, name + "/model.toml");
}
inline ModelFolder pendulum(const std::string& joint_default) {
  return small_model(joint_default, kPendulumUrdf, "pendulum");
}
inline ModelFolder two_links(const std::string& joint_default) {
  return small_model(joint_default, kTwoLinksUrdf, "two");
}
inline ModelFolder slider(const std::string& joint_default) {
  return small_model(joint_default, kSliderUrdf, "slider");
}
inline ModelFolder arm(const std::string& joint_default) {
  return small_model(joint_default, kArmUrdf, "arm");
}

/// A robot that a law of the diagnosis must hold on.
struct SmallWorld {
  std::string name;
  ModelFolder model;
};

/// One of each kind: a joint behind a servo, two joints under torque, a sliding joint in a position
/// loop. Friction, rotor and limits are stated, so that what changes them finds something.
inline std::vector<SmallWorld> small_worlds() {
  const std::string stated = "armature = 0.02\nviscous = 0.05\ncoulomb = 0.04\n";
  return {{"servo_pendulum", pendulum("actuator = \"dc_servo\"\ncurrent_limit = 2.0\n" + stated)},
          {"torque_arm", two_links("actuator = \"torque\"\n" + stated)},
          {"position_slider", slider("actuator = \"position_pd\"\nkp = 300\nkd = 15\n"
                                     "torque_limit = 30\narmature = 0.2\nviscous = 0.5\n"
                                     "coulomb = 0.4\n")}};
}

/// The same robot in a world with `effects` that the model does not know.
inline ModelFolder hiding(ModelFolder model, const std::vector<EffectEntry>& effects) {
  model.effects.insert(model.effects.end(), effects.begin(), effects.end());
  return model;
}

/// A drive with equal time steps whose joints follow command(joint, t); measured positions are
/// zero.
inline Drive make_test_drive(const ModelFolder& model, double duration, double period,
                             const std::function<double(int, double)>& command) {
  Drive drive;
  drive.name = "made";
  const auto rows = static_cast<std::size_t>(std::lround(duration / period)) + 1;
  for (std::size_t k = 0; k < rows; ++k) drive.t.push_back(static_cast<double>(k) * period);
  for (std::size_t j = 0; j < model.tree.size(); ++j) {
    JointData data;
    data.q.assign(rows, 0.0);
    for (double t : drive.t) data.command.push_back(command(static_cast<int>(j), t));
    drive.joints.push_back(data);
  }
  return drive;
}

inline Window whole(const Drive& drive, std::vector<double> q, std::vector<double> dq) {
  return {0, drive.rows() - 1, std::move(q), std::move(dq)};
}
inline Window whole_from_rest(const Drive& drive) {
  return whole(drive, std::vector<double>(drive.joints.size(), 0.0),
               std::vector<double>(drive.joints.size(), 0.0));
}

/// What is recorded of a world beside commands and positions.
struct Recorded {
  std::string file = "made.csv";
  bool velocity = false, duty = false;
  std::uint64_t noise_seed = 0;   // not 0: the noise and the encoder step that the model states
  std::uint64_t chance_seed = 0;  // not 0: lost commands and reading jitter are drawn
};

/// What `world` (its [[effect]] entries included) does under `drive`, from rest at zero.
inline recording::Recording record(const ModelFolder& world, const Drive& drive,
                                   const Recorded& how = {}) {
  const SimParams params = params_with_effects(world);
  SimOptions options;
  options.random_seed = how.chance_seed;
  Prediction p =
      simulate(params, drive, std::vector<Window>{whole_from_rest(drive)}, options).front();
  if (how.chance_seed != 0) add_reading_jitter(params, how.chance_seed, p);
  if (how.noise_seed != 0) add_sensor_noise(params, how.noise_seed, p);
  recording::Recording r;
  r.file = how.file;
  r.t = drive.t;
  for (std::size_t j = 0; j < world.tree.size(); ++j) {
    const std::string& name = world.tree.joints[j].name;
    const auto set = [&](const std::string& kind, const std::vector<double>& channel) {
      const auto values = p.of(channel, j);
      r.set(kind + ":" + name, {values.begin(), values.end()});
    };
    const bool torque =
        world.joints[static_cast<std::size_t>(j)].actuator == recording::Actuator::torque;
    r.set((torque ? "tau_cmd:" : "u:") + name, drive.joints[static_cast<std::size_t>(j)].command);
    set("q", p.q);
    if (how.velocity) set("dq", p.dq);
    if (how.duty) set("pwm", p.pwm);
  }
  return r;
}

}  // namespace sanso::diagnose::test
