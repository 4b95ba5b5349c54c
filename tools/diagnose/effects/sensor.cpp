// Sensors: S1 to S5 of the method page. The IMU's need a moving base and are not simulated here.
#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {
namespace {

Effect encoder(Effect effect) {
  return of_chapter({Family::sensor, Port::sensor, Scope::joint, kR2 | kR6}, std::move(effect));
}
Effect imu(Effect effect) {
  return of_chapter({Family::sensor, Port::sensor, Scope::robot, kR2 | kR6}, std::move(effect));
}

Effect encoder_offset() {
  return encoder({
      .id = "encoder_offset",
      .code = "S1",
      .name = "encoder offset",
      .form = "reading + offset (of_record: in the recording alone, the servo reads its own)",
      .parameters = {{"offset", "rad", 0, -0.3, 0.3, 0.02, Unit::angle},
                     {"of_record", "-", 0, 0, 1, 1, Unit::none, true}},
      .probes = {{0.02, 0}, {0.02, 1}},
      .cluster = "E",
      .confounders = {"link_com", "ground_slope", "imu_misalignment", "cable_spring"},
      .regimes = {"standstill", "high load"},
      .signature = "a static error of gravity",
      .experiments = {kTilt, kOutsideSensor, kPostures},
      .identified = {Identified::always},
      .tolerances = {{.name = "zero",
                      .order = 8,
                      .deviation = &ToleranceSettings::zero,
                      .direction = everywhere({1.0, 0.0}),
                      .sliding = 0.1}},
      .effort = {.kind = EffortKind::zero,
                 .tolerance = EffortTolerance{3, &ToleranceSettings::zero, where_it_turns}},
      .drive = DriveQuestion{JointFigure::zero, true},
      .apply =
          [](SimParams& p, int j, Theta x) {
            const bool of_record = x[1] > 0.5;
            (of_record ? joint(p, j).record_offset : joint(p, j).encoder_offset) += x[0];
          },
  });
}

Effect encoder_nonlinearity() {
  return encoder({
      .id = "encoder_nonlinearity",
      .code = "S2",
      .name = "encoder nonlinearity or scale",
      .form = "(1 + scale) q + sine sin(q) + cosine cos(q)",
      .parameters = {{"sine", "rad", 0, -0.1, 0.1, 0.005, Unit::angle},
                     {"cosine", "rad", 0, -0.1, 0.1, 0.005, Unit::angle},
                     {"scale", "-", 0, -0.05, 0.05, 0.01}},
      .probes = {{0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.02}},
      .confounders = {"gear_kinematic_error", "link_geometry"},
      .contains = {"encoder_offset"},
      .regimes = {"standstill", "low speed"},
      .signature = "once per turn, no torque",
      .experiments = {kOutsideSensor, kFullRange},
      // a zero that is known to so much is known so at every angle
      .law = {&ToleranceSettings::zero, {0, 1}, {}, where_it_turns},
      .apply =
          [](SimParams& p, int j, Theta x) {
            if (x[0] != 0.0 || x[1] != 0.0) joint(p, j).encoder_error = {x[0], x[1], 1.0};
            joint(p, j).encoder_scale += x[2];
          },
  });
}

Effect velocity_filter() {
  return encoder({
      .id = "velocity_filter",
      .code = "S3",
      .name = "filter of the velocity channel",
      .form = "dq channel through first order `time`",
      .parameters = {{"time", "s", 0, 0, 0.05, 0.005, Unit::none, false, Role::filter}},
      .probes = {{0.01}},
      .sign = 1,
      .residuals = kR1 | kR2,
      .needs = kVelocity,
      .confounders = {"sensor_delay"},
      .regimes = {"accelerating"},
      .signature = "dq column against the slope of q",
      .experiments = {kChirp},
      .apply = adds(&JointParams::velocity_filter),
  });
}

Effect imu_bias() {
  return imu({
      .id = "imu_bias",
      .code = "S4",
      .name = "IMU bias and scale",
      .form = "reading + bias",
      .parameters = {{"gyro_x", "rad/s", 0, -0.1, 0.1, 0.01},
                     {"gyro_y", "rad/s", 0, -0.1, 0.1, 0.01},
                     {"gyro_z", "rad/s", 0, -0.1, 0.1, 0.01},
                     {"acc_x", "m/s^2", 0, -2, 2, 0.2},
                     {"acc_y", "m/s^2", 0, -2, 2, 0.2},
                     {"acc_z", "m/s^2", 0, -2, 2, 0.2}},
      .residuals = kR5 | kR6,
      .needs = kImu,
      .confounders = {"imu_misalignment", "ground_slope"},
      .regimes = {"standstill"},
      .signature = "at rest",
      .whole = WholeFigure::imu_bias,
  });
}

Effect imu_misalignment() {
  return imu({
      .id = "imu_misalignment",
      .code = "S5",
      .name = "IMU misalignment",
      .form = "reading turned by a small rotation",
      .parameters = {{"x", "rad", 0, -0.09, 0.09, 0.02},
                     {"y", "rad", 0, -0.09, 0.09, 0.02},
                     {"z", "rad", 0, -0.09, 0.09, 0.02}},
      .residuals = kR6,
      .needs = kImu,
      .cluster = "E",
      .confounders = {"ground_slope", "link_com", "encoder_offset"},
      .regimes = {"standstill"},
      .signature = "attitude constant in the body",
      .whole = WholeFigure::imu_turn,
  });
}

Effect pose_scale() {
  return imu({
      .id = "pose_scale",
      .code = "S6",
      .name = "scale of the recorded base positions",
      .form = "position times scale",
      .parameters = {{"scale", "-", 1, 0.8, 1.25, 0.02}},
      .residuals = kR5 | kR6,
      .needs = kGround,
      .regimes = {"flight", "standstill"},
      .signature = "pace of free fall, and height at rest",
      .whole = WholeFigure::pose_scale,
  });
}

Effect pose_tilt() {
  return imu({
      .id = "pose_tilt",
      .code = "S8",
      .name = "vertical of the recorded base poses",
      .form = "true vertical turned in their axes",
      .parameters = {{"x", "rad", 0, -0.09, 0.09, 0.01}, {"y", "rad", 0, -0.09, 0.09, 0.01}},
      .residuals = kR6,
      .needs = kGround,
      .cluster = "E",
      .confounders = {"ground_slope", "imu_misalignment"},
      .regimes = {"standstill"},
      .signature = "accelerometer against attitude, constant in the world",
      .whole = WholeFigure::pose_tilt,
  });
}

Effect foot_force_scale() {
  return imu({
      .id = "foot_force_scale",
      .code = "S7",
      .name = "scale of the recorded foot forces",
      .form = "force times scale",
      .parameters = {{"scale", "-", 1, 0.5, 2, 0.02}},
      .residuals = kR5,
      .needs = kGround,
      .confounders = {"link_mass", "payload"},
      .regimes = {"stance"},
      .signature = "sum of the feet against the weight",
      .whole = WholeFigure::force_scale,
  });
}

}  // namespace

std::vector<Effect> sensor_effects() {
  return {encoder_offset(),   encoder_nonlinearity(), velocity_filter(), imu_bias(),
          imu_misalignment(), pose_scale(),           pose_tilt(),       foot_force_scale()};
}

}  // namespace sanso::diagnose
