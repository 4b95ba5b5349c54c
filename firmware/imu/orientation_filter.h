// Orientation from gyro and accelerometer for sensors that give none (OpenCR, gamepads): Mahony's
// complementary filter, and the gyro's bias learnt while the robot is at rest. Yaw is integrated
// only. Real-time safe. Source: R. Mahony, T. Hamel, J.-M. Pflimlin, "Nonlinear complementary
// filters on the special orthogonal group", IEEE TAC 53(5), 2008.
#pragma once

#include "shared/math/so3.h"

namespace sanso::firmware {

class OrientationFilter {
 public:
  /// One sample: rate [rad/s], specific force [m/s^2, +9.81 upwards at rest], both in body axes,
  /// `dt` seconds after the one before. The first sample sets the tilt, yaw 0.
  void update(const math::Vec3& gyro, const math::Vec3& accel, double dt);

  /// Turns body components into world; z upwards, heading from where the filter began.
  const math::Quat& quat_world_body() const { return quat_; }
  /// What the gyro shows at rest [rad/s].
  const math::Vec3& bias() const { return bias_; }
  /// The bias has been learnt.
  bool bias_known() const { return bias_known_; }

 private:
  void learn_bias(const math::Vec3& gyro, double force, double dt);

  math::Quat quat_ = math::quat_identity();
  math::Vec3 bias_ = math::Vec3::Zero();
  math::Vec3 mean_ = math::Vec3::Zero();  // of the gyro, slow
  double spread_ = 0;                     // mean square deviation from it
  double rest_s_ = 0;
  bool started_ = false, bias_known_ = false;
};

}  // namespace sanso::firmware
