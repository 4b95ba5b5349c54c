// Sensors: S1 to S5 of the method page. The IMU's need a moving base and are not simulated here.
#include "tools/diagnose/effects/families.h"

namespace sanso::diagnose {

std::vector<Effect> sensor_effects() {
  constexpr Family F = Family::sensor;
  constexpr Port P = Port::sensor;
  constexpr Scope S = Scope::joint;
  return {
      {"encoder_offset", "S1", "encoder offset", "reading + offset", F, P, S,
       {{"offset", "rad", 0, -0.1, 0.1, 0.02, Unit::angle}},
       true, {{0.02}}, 0, kR2 | kR6, 0, "E", {"link_com", "ground_slope", "imu_misalignment", "cable_spring"}, {"standstill", "high load"},
       "a static error of gravity", {kTilt, kOutsideSensor, kPostures},
       [](SimParams& p, int j, Theta x) { joint(p, j).encoder_offset += x[0]; }},
      {"encoder_nonlinearity", "S2", "encoder nonlinearity or scale", "(1 + scale) q + sine sin(q) + cosine cos(q)", F, P, S,
       {{"sine", "rad", 0, -0.03, 0.03, 0.005, Unit::angle}, {"cosine", "rad", 0, -0.03, 0.03, 0.005, Unit::angle}, {"scale", "-", 0, -0.05, 0.05, 0.01}},
       true, {{0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.02}}, 0, kR2 | kR6, 0, "", {"gear_kinematic_error", "link_geometry"}, {"standstill", "low speed"},
       "once per turn, no torque", {kOutsideSensor, kFullRange},
       [](SimParams& p, int j, Theta x) {
         if (x[0] != 0.0 || x[1] != 0.0) joint(p, j).encoder_error = {x[0], x[1], 1.0};
         joint(p, j).encoder_scale += x[2];
       }},
      {"velocity_filter", "S3", "filter of the velocity channel", "dq channel through first order `time`", F, P, S,
       {{"time", "s", 0, 0, 0.05, 0.005}},
       true, {{0.01}}, 1, kR1 | kR2, kVelocity, "", {"sensor_delay"}, {"accelerating"}, "dq column against the slope of q", {kChirp},
       [](SimParams& p, int j, Theta x) { joint(p, j).velocity_filter += x[0]; }},
      {"imu_bias", "S4", "IMU bias and scale", "reading + bias", F, P, Scope::robot,
       {{"gyro_x", "rad/s", 0, -0.1, 0.1, 0.01}, {"gyro_y", "rad/s", 0, -0.1, 0.1, 0.01}, {"gyro_z", "rad/s", 0, -0.1, 0.1, 0.01}},
       true, {}, 0, kR5 | kR6, kImu, "", {"imu_misalignment", "ground_slope"}, {"standstill"}, "at rest", {}, nullptr},
      {"imu_misalignment", "S5", "IMU misalignment", "reading turned by a small rotation", F, P, Scope::robot,
       {{"x", "rad", 0, -0.09, 0.09, 0.02}, {"y", "rad", 0, -0.09, 0.09, 0.02}, {"z", "rad", 0, -0.09, 0.09, 0.02}},
       true, {}, 0, kR6, kImu, "E", {"ground_slope", "link_com", "encoder_offset"}, {"standstill"}, "attitude constant in the body", {}, nullptr},
  };
}

}  // namespace sanso::diagnose
