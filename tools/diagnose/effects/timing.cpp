// Clocks and delays: D1 to D6 of the method page.
#include <algorithm>
#include <cmath>

#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {
namespace {

Effect of_commands(Effect effect) {
  return of_chapter({Family::timing, Port::command_path, Scope::joint, kR2 | kR4 | kR7},
                    std::move(effect));
}
Effect of_readings(Effect effect) {
  return of_chapter({Family::timing, Port::sensor, Scope::joint, kR2 | kR4 | kR7},
                    std::move(effect));
}
Effect of_clock(Effect effect) {
  return of_chapter({Family::timing, Port::clock, Scope::joint, kR2 | kR4 | kR7},
                    std::move(effect));
}
Effect of_bus(Effect effect) {
  return of_chapter({Family::timing, Port::command_path, Scope::robot, kR2 | kR4 | kR7},
                    std::move(effect));
}

Effect command_delay() {
  return of_commands({
      .id = "command_delay",
      .code = "D1",
      .name = "command delay",
      .form = "goal(t - delay)",
      .parameters = {{"delay", "s", 0, 0, 0.12, 0.005, Unit::none, false, Role::delay}},
      .probes = {{0.005}, {0.02}},
      .sign = 1,
      .needs = kCommand,
      .cluster = "B",
      .confounders = {"sensor_delay", "servo_d_gain", "servo_profile", "joint_compliance",
                      "sample_hold", "backlash"},
      .regimes = {"near command step", "high speed"},
      .signature = "grows with the goal's speed; phase linear in frequency",
      .experiments = {kChirp, kTorqueOff},
      .settings = {added_to(&JointSettings::command_delay_s)},
      .identified = {Identified::always},
      // Either way: a servo that samples at 1 kHz tracks as if its commands came half a sample
      // early. Bounded at zero, the fraction of a millisecond takes the next name that can shift a
      // command forward (feed-forward).
      .tolerances = {{.name = "common lag",
                      .order = 11,
                      .deviation = &ToleranceSettings::lag,
                      .direction = everywhere({1.0}),
                      .common = true}},
      .drive = DriveQuestion{JointFigure::lag, true},
      .apply = adds(&JointParams::command_delay),
  });
}

Effect sensor_delay() {
  return of_readings({
      .id = "sensor_delay",
      .code = "D2",
      .name = "sensor delay",
      .form = "reading(t - delay)",
      .parameters = {{"delay", "s", 0, 0, 0.12, 0.005, Unit::none, false, Role::delay}},
      .probes = {{0.005}, {0.02}},
      .sign = 1,
      .residuals = kR2 | kR4 | kR7 | kR1,
      .cluster = "B",
      .confounders = {"command_delay", "servo_d_gain", "servo_profile", "joint_compliance",
                      "velocity_filter"},
      .regimes = {"high speed", "accelerating"},
      .signature = "like the command's, but also where no command changes",
      .experiments = {kTorqueOff, kOutsideSensor},
      .settings = {added_to(&JointSettings::sensor_delay_s)},
      .apply = adds(&JointParams::sensor_delay),
  });
}

Effect sample_hold() {
  return of_commands({
      .id = "sample_hold",
      .code = "D3",
      .name = "commands taken at a lower rate",
      .form = "every `cycles`-th command, held",
      .parameters = {{"cycles", "-", 1, 1, 4, 1, Unit::none, true}},
      .smooth = false,
      .probes = {{2}, {3}, {4}},
      .sign = 1,
      .needs = kCommand,
      .confounders = {"command_delay", "packet_loss"},
      .regimes = {"high speed"},
      .signature = "stair case",
      .experiments = {kSteps},
      .apply =
          [](SimParams& p, int j, Theta x) {
            joint(p, j).hold_cycles = std::max(1, static_cast<int>(std::lround(x[0])));
          },
  });
}

Effect timing_jitter() {
  return of_clock({
      .id = "timing_jitter",
      .code = "D4",
      .name = "jitter of the readings",
      .form = "instant of a reading ~ N(t, jitter^2)",
      .parameters = {{"jitter", "s", 0, 0, 0.008, 0.001, Unit::none, true}},
      .random = true,
      .probes = {{0.002}},
      .sign = 1,
      .residuals = kR1 | kR7,
      .regimes = {"high speed"},
      .signature = "scatter grows with speed, mean zero",
      .experiments = {kChirp},
      .apply = [](SimParams& p, int j,
                  Theta x) { joint(p, j).jitter = std::hypot(joint(p, j).jitter, x[0]); },
  });
}

Effect packet_loss() {
  return of_commands({
      .id = "packet_loss",
      .code = "D5",
      .name = "lost commands",
      .form = "a command is lost with probability `loss`; the one before stays",
      .parameters = {{"loss", "-", 0, 0, 0.6, 0.05, Unit::none, true}},
      .random = true,
      .probes = {{0.1}, {0.3}},
      .sign = 1,
      .residuals = kR2 | kR4 | kR7 | kR1,
      .needs = kCommand,
      .confounders = {"command_delay", "sensor_delay", "coulomb_friction", "sample_hold"},
      .regimes = {"high speed"},
      .signature = "repeats and bursts",
      .experiments = {kSteps},
      .apply = [](SimParams& p, int j,
                  Theta x) { joint(p, j).loss = 1.0 - (1.0 - joint(p, j).loss) * (1.0 - x[0]); },
  });
}

Effect bus_skew() {
  return of_bus({
      .id = "bus_skew",
      .code = "D6",
      .name = "skew along the bus",
      .form = "command of the k-th joint comes k `skew` later",
      .parameters = {{"skew", "s", 0, 0, 0.002, 0.0002}},
      .probes = {{0.001}},
      .sign = 1,
      .needs = kCommand | kTwoJoints,
      .confounders = {"command_delay"},
      .regimes = {"high speed"},
      .signature = "linear in the order of the bus",
      .experiments = {kChirp},
      .apply =
          [](SimParams& p, int, Theta x) {
            for (std::size_t j = 0; j < p.joints.size(); ++j)
              p.joints[j].command_delay += static_cast<double>(j) * x[0];
          },
  });
}

}  // namespace

std::vector<Effect> timing_effects() {
  return {command_delay(), sensor_delay(), sample_hold(),
          timing_jitter(), packet_loss(),  bus_skew()};
}

}  // namespace sanso::diagnose
