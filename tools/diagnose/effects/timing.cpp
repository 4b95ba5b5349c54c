// Clocks and delays: D1 to D6 of the method page.
#include <algorithm>
#include <cmath>

#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {

std::vector<Effect> timing_effects() {
  constexpr Family F = Family::timing;
  constexpr Scope S = Scope::joint;
  constexpr unsigned R = kR2 | kR4 | kR7;
  return {
      {"command_delay", "D1", "command delay", "goal(t - delay)", F, Port::command_path, S,
       {{"delay", "s", 0, 0, 0.06, 0.005}},
       true, {{0.005}, {0.02}}, 1, R, kCommand, "B", {"sensor_delay", "servo_d_gain", "servo_profile", "joint_compliance", "sample_hold", "backlash"},
       {"near command step", "high speed"}, "grows with the goal's speed; phase linear in frequency", {kChirp, kTorqueOff},
       [](SimParams& p, int j, Theta x) { joint(p, j).command_delay += x[0]; }},
      {"sensor_delay", "D2", "sensor delay", "reading(t - delay)", F, Port::sensor, S,
       {{"delay", "s", 0, 0, 0.06, 0.005}},
       true, {{0.005}, {0.02}}, 1, R | kR1, 0, "B", {"command_delay", "servo_d_gain", "servo_profile", "joint_compliance", "velocity_filter"},
       {"high speed", "accelerating"}, "like the command's, but also where no command changes", {kTorqueOff, kOutsideSensor},
       [](SimParams& p, int j, Theta x) { joint(p, j).sensor_delay += x[0]; }},
      {"sample_hold", "D3", "commands taken at a lower rate", "every `cycles`-th command, held", F, Port::command_path, S,
       {{"cycles", "-", 1, 1, 4, 1, Unit::none, true}},
       false, {{2}, {3}, {4}}, 1, R, kCommand, "", {"command_delay", "packet_loss"}, {"high speed"}, "stair case", {kSteps},
       [](SimParams& p, int j, Theta x) { joint(p, j).hold_cycles = std::max(1, static_cast<int>(std::lround(x[0]))); }},
      {"timing_jitter", "D4", "jitter of the readings", "instant of a reading ~ N(t, jitter^2)", F, Port::clock, S,
       {{"jitter", "s", 0, 0, 0.008, 0.001}},
       true, {{0.002}}, 1, kR1 | kR7, 0, "", {}, {"high speed"}, "scatter grows with speed, mean zero", {kChirp},
       [](SimParams& p, int j, Theta x) { joint(p, j).jitter = std::hypot(joint(p, j).jitter, x[0]); }},
      {"packet_loss", "D5", "lost commands", "a command is lost with probability `loss`; the one before stays", F, Port::command_path, S,
       {{"loss", "-", 0, 0, 0.3, 0.05}},
       true, {{0.1}, {0.3}}, 1, R | kR1, kCommand, "", {"command_delay", "coulomb_friction", "sample_hold"}, {"high speed"}, "repeats and bursts", {kSteps},
       [](SimParams& p, int j, Theta x) { joint(p, j).loss = 1.0 - (1.0 - joint(p, j).loss) * (1.0 - x[0]); }},
      {"bus_skew", "D6", "skew along the bus", "command of the k-th joint comes k `skew` later", F, Port::command_path, Scope::robot,
       {{"skew", "s", 0, 0, 0.002, 0.0002}},
       true, {{0.001}}, 1, R, kCommand | kTwoJoints, "", {"command_delay"}, {"high speed"}, "linear in the order of the bus", {kChirp},
       [](SimParams& p, int, Theta x) {
         for (std::size_t j = 0; j < p.joints.size(); ++j) p.joints[j].command_delay += static_cast<double>(j) * x[0];
       }},
  };
}

}  // namespace sanso::diagnose
