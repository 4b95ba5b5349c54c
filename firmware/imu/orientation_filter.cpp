// The accelerometer pulls the tilt with a gain that falls to nothing as its length departs from
// gravity; the bias is a slow mean of the gyro over times without motion.
#include "firmware/imu/orientation_filter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "firmware/exchange/samples.h"

namespace sanso::firmware {
namespace {

constexpr double kTiltGain = 0.5;    // 1/s: the accelerometer corrects tilt within two seconds
constexpr double kForceRange = 0.2;  // beyond +-20 % of gravity it shows motion, not tilt
constexpr double kMeanTime_s = 0.3, kBiasTime_s = 1.0, kRestTime_s = 0.5;
constexpr double kRestSpread = 0.02;   // rad/s rms: more is motion
constexpr double kLargestBias = 0.15;  // rad/s: more is a turn at constant rate
constexpr double kRestForce = 0.05;    // share of gravity

}  // namespace

void OrientationFilter::learn_bias(const math::Vec3& gyro, double force, double dt) {
  const double share = std::min(1.0, dt / kMeanTime_s);
  const math::Vec3 off = gyro - mean_;
  mean_ += share * off;
  spread_ += share * (off.squaredNorm() - spread_);
  const bool rest = spread_ < kRestSpread * kRestSpread && mean_.norm() < kLargestBias &&
                    std::abs(force / kGravity - 1.0) < kRestForce;
  rest_s_ = rest ? rest_s_ + dt : 0.0;
  if (rest_s_ < kRestTime_s) return;
  bias_ += bias_known_ ? math::Vec3(std::min(1.0, dt / kBiasTime_s) * (mean_ - bias_))
                       : math::Vec3(mean_ - bias_);
  bias_known_ = true;
}

void OrientationFilter::update(const math::Vec3& gyro, const math::Vec3& accel, double dt) {
  const double force = accel.norm();
  if (!started_) {
    if (force < 0.5 * kGravity) return;
    const double roll = std::atan2(accel[1], accel[2]);
    const double pitch = std::atan2(-accel[0], std::hypot(accel[1], accel[2]));
    quat_ = math::quat_multiply(math::quat_exp({0, pitch, 0}), math::quat_exp({roll, 0, 0}));
    mean_ = gyro;
    started_ = true;
    return;
  }
  learn_bias(gyro, force, dt);
  const math::Vec3 up_in_body =
      math::rotation_matrix(quat_).transpose() * math::Vec3(math::Vec3::UnitZ());
  const double trust = std::max(0.0, 1.0 - std::abs(force / kGravity - 1.0) / kForceRange);
  math::Vec3 rate = gyro - bias_;
  if (trust > 0) rate += kTiltGain * trust * (accel / force).cross(up_in_body);
  quat_ = math::quat_normalized(math::quat_multiply(quat_, math::quat_exp(rate * dt)));
}

}  // namespace sanso::firmware
