// The whole robot on a floor: legs of the stand, a trunk that floats, flat soles, an IMU, a camera
// that sees the trunk, forces under the feet. On MuJoCo; nothing here is the diagnosis's.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/conceal/floor_motion.h"
#include "tools/recording/recording.h"

namespace sanso::conceal {

/// The trunk and all that is fixed to it: a point of the links' list that has no joint.
struct TrunkSpec {
  double mass = 0;
  Vec3 com{};
  double inertia[6] = {};  // ixx iyy izz ixy ixz iyz about the COM, kg m^2
};

/// What a joint's drive is, beside the common gain and damping.
struct FloorDrive {
  double gain = 1;                        // of its stiffness
  double coulomb = 0.05, viscous = 0.05;  // N m, N m s/rad
  double zero = 0;                        // rad: it reads its angle plus this, and holds that
  // of no library: a torque that oscillates, whatever the joint does; a share of the neighbour's
  // goal that leaks into its own
  double hum = 0, hum_hz = 1, leak = 0;  // N m, Hz, -
};

/// Somebody pushes the trunk, in every recording anew.
struct FloorPush {
  double force = 0, length = 0.2;  // N along the floor, s
  int times = 2;
};

/// What may be hidden beside the figures of robot and trunk.
struct FloorTruth {
  RobotSpec legs;
  TrunkSpec trunk;
  double payload_kg = 0;           // on the trunk
  Vec3 payload_at{};               // m
  Vec3 imu_turn{};                 // rotation vector of the sensor's axes in the trunk's, rad
  Vec3 gyro_bias{}, acc_bias{};    // rad/s, m/s^2
  Vec3 slope{};                    // of the floor about world x and y, rad
  double force_scale = 1;          // of the soles' sensors
  double friction = 0.8;           // of the soles
  double kp = 21.1, kd = 1.084;    // of the drives, N m/rad, N m s/rad
  double armature = 0.03;          // kg m^2
  std::vector<FloorDrive> drives;  // by joint
  double delay_s = 0;              // from a goal to the drives
  FloorPush push;
  double fan = 0, fan_hz = 1;  // N along the trunk's x axis, to and fro
  double camera_noise_m = 2e-4, camera_noise_rad = 1e-3;
};

/// Legs and trunk of the OP3; arms and head are part of the trunk.
FloorTruth nominal_floor();

/// One recording of 12 s, shorter where the robot falls. Deterministic: `seed` draws noise and the
/// moments of pushes only.
recording::Recording run_on_floor(const FloorTruth& truth, const FloorMotion& motion,
                                  std::uint64_t seed);

/// URDF of the model folder: the trunk floats, soles are boxes.
std::string floor_urdf(const FloorTruth& nominal);

}  // namespace sanso::conceal
