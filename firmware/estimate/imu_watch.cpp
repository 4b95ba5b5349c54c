// Comparisons over fading windows; each needs motion or time, none needs stillness. The lean is
// compared until it has once agreed: a screw does not turn a sensor by a right angle later, and a
// robot that is pushed onto the edge of its feet leans where its legs do not say so.
#include "firmware/estimate/imu_watch.h"

#include <algorithm>
#include <cmath>

namespace sanso::firmware {
namespace {

using math::Vec3;
constexpr double kForceWindow_s = 1.0, kForceTolerance = 3.0;  // m/s^2
constexpr double kRateWindow_s = 0.2, kRateTolerance_rad = 0.2;
// legs: only where both have turned the trunk noticeably, and by like amounts
constexpr double kLegsWindow_s = 0.4, kEnoughMotion = 0.01;  // rad^2/s
constexpr double kLikeAmounts = 2.5, kLeastCorrelation = 0.3;
constexpr int kContradictingTicks = 5;
// a sensor that has agreed with the legs is not turned a moment later; soles that rock over what
// they stand on turn the trunk otherwise than the legs for a few tenths of a second
constexpr int kContradictingTicksOnceKnown = 50;
// mounting: a lean of 0.7 degrees tells; noise and play of a standing robot are a third of it, and
// at twice as much a robot that is corrected the wrong way can no longer be saved
constexpr double kLeanMean_s = 3.0, kEnoughLean_rad = 0.012;
// from two degrees on the soles may have left the ground, and a balance that leans the legs forward
// because the trunk rocks back looks like a turned sensor: nothing is concluded until torque is off
constexpr double kOnItsSoles_rad = 0.035;
constexpr double kAgreement = 0.8;
// what it is compared with is the lean of a robot that stood: between two steps soles lie on one
// plane for less, and then for a moment only nearly so
constexpr double kStood_s = 0.4, kSettlingMean_s = 0.1;
// rates of one direction vouch for the sensor: turned by a right angle it shows none along theirs.
// A trunk whose gears have play leans a degree another way than its joints say, but turns with them
constexpr double kVouches = 0.5, kVouchingMotion = 0.0004;  // correlation; rad^2/s
constexpr double kProves = 0.8, kProvingMotion = 0.001;
// of the lean: legs that tell of it less alike are not on the ground both
constexpr double kOneLifts = 0.5;
// soles that lie on one plane
constexpr double kParallel_rad = 0.06, kLevel_m = 0.006;
// the legs turn the trunk alike while both soles stand: a sole that slips or lifts says otherwise
constexpr double kLegsAgree_rad_s = 0.3;

void fade(double& sum, double dt, double window_s, double increment) {
  sum += increment - sum * dt / window_s;
}

}  // namespace

void ImuWatch::update(Nanoseconds now, const ImuSample& imu, const Estimator& estimator,
                      bool standing) {
  if (imu.time == 0 || now - imu.time > from_seconds(settings_.silent_s)) return;
  const double dt = to_seconds(imu.time - last_.time);
  const bool first = last_.time == 0;
  if (!first && imu.sequence == last_.sequence) return;
  if (first || dt <= 0 || dt > settings_.silent_s) {
    reset();
    last_ = imu;
    return;
  }
  heard_s_ += dt;
  reason_ = kPlausible;
  if (gravity_wrong(dt, imu)) reason_ = kOtherGravity;
  if (rate_wrong(dt, imu)) reason_ = kRate;
  if (!standing) lean_ = Lean{}, rocked_ = false;
  if (estimator.on_wheels()) {  // a foot turns with the ground under its wheels
    last_ = imu;
    return;
  }
  if (legs_contradict(dt, imu, estimator)) reason_ = kAgainstLegs;
  // on whatever the soles lie, and after rocking too: a turned sensor shows no rates along theirs
  if (standing && rates_agree(kProves, kProvingMotion)) mounting_known_ = true;
  if (standing && !mounting_known_ && !rocked_ && leans_another_way(dt, imu, estimator))
    reason_ = kAgainstLegs;
  last_ = imu;
}

bool ImuWatch::gravity_wrong(double dt, const ImuSample& imu) {
  const Vec3 force_in_world =
      math::rotation_matrix(math::quat_normalized(imu.quat_world_base)) * imu.accel;
  if (heard_s_ <= dt) mean_force_in_world_ = Vec3(0, 0, kGravity);
  mean_force_in_world_ += (force_in_world - mean_force_in_world_) * (dt / kForceWindow_s);
  return (mean_force_in_world_ - Vec3(0, 0, kGravity)).norm() > kForceTolerance;
}

bool ImuWatch::rate_wrong(double dt, const ImuSample& imu) {
  const math::Quat quat_then_now =
      math::quat_multiply(math::quat_conjugate(math::quat_normalized(last_.quat_world_base)),
                          math::quat_normalized(imu.quat_world_base));
  const Vec3 turned = math::quat_log(quat_then_now);
  const Vec3 by_gyro = 0.5 * dt * (imu.gyro + last_.gyro);
  drift_in_base_ += turned - by_gyro - drift_in_base_ * (dt / kRateWindow_s);
  return drift_in_base_.norm() > kRateTolerance_rad;
}

bool ImuWatch::legs_contradict(double dt, const ImuSample& imu, const Estimator& estimator) {
  const Vec3 right = estimator.base_rate_by_leg(kRightLeg);
  const Vec3 left = estimator.base_rate_by_leg(kLeftLeg);
  const bool both = estimator.contact_bits() == 3 && (right - left).norm() < kLegsAgree_rad_s;
  const Eigen::Vector2d by_legs = 0.5 * (right + left).head<2>();
  const Eigen::Vector2d by_imu = imu.gyro.head<2>();
  const double weight = both ? dt : 0.0;
  fade(legs_legs_, dt, kLegsWindow_s, weight * by_legs.squaredNorm());
  fade(imu_imu_, dt, kLegsWindow_s, weight * by_imu.squaredNorm());
  fade(legs_imu_, dt, kLegsWindow_s, weight * by_legs.dot(by_imu));
  const bool telling = legs_legs_ > kEnoughMotion && imu_imu_ > legs_legs_ / kLikeAmounts &&
                       imu_imu_ < legs_legs_ * kLikeAmounts;
  const bool contradicts =
      telling && legs_imu_ < kLeastCorrelation * std::sqrt(legs_legs_ * imu_imu_);
  contradicting_ticks_ = contradicts ? contradicting_ticks_ + 1 : 0;
  return contradicting_ticks_ >=
         (mounting_known_ ? kContradictingTicksOnceKnown : kContradictingTicks);
}

/// Whether the trunk has just turned as the legs turned it.
bool ImuWatch::rates_agree(double correlation, double motion) const {
  return legs_legs_ > motion && imu_imu_ > motion &&
         legs_imu_ > correlation * std::sqrt(legs_legs_ * imu_imu_);
}

/// Which way the trunk leans on soles that lie on the ground, told by the legs and by the IMU. Does
/// not ask the estimator which soles are loaded: it asks the IMU.
bool ImuWatch::leans_another_way(double dt, const ImuSample& imu, const Estimator& estimator) {
  const SoleKinematics& right = estimator.sole(kRightLeg);
  const SoleKinematics& left = estimator.sole(kLeftLeg);
  const Vec3 up_right = right.R_base_sole.col(2), up_left = left.R_base_sole.col(2);
  const bool on_one_plane =
      (up_right - up_left).norm() < kParallel_rad &&
      std::abs((right.p_base_sole - left.p_base_sole).dot(up_right)) < kLevel_m;
  if (!on_one_plane) {
    lean_ = Lean{};
    return false;
  }
  const Eigen::Vector2d by_legs = 0.5 * (up_right + up_left).head<2>();
  const Eigen::Vector2d between_legs = (up_right - up_left).head<2>();
  const math::Mat3 R_world_base = math::rotation_matrix(math::quat_normalized(imu.quat_world_base));
  const Eigen::Vector2d by_imu = R_world_base.row(2).head<2>().transpose();
  if (!lean_.begun) {
    lean_.begun = true;
    lean_.mean_by_legs = by_legs;
    lean_.mean_by_imu = by_imu;
    lean_.mean_between_legs = between_legs;
  }
  lean_.stood_s += dt;
  const bool stood = lean_.stood_s > kStood_s;
  const double share = dt / std::max(dt, stood ? kLeanMean_s : kSettlingMean_s);
  lean_.mean_by_legs += (by_legs - lean_.mean_by_legs) * share;
  lean_.mean_by_imu += (by_imu - lean_.mean_by_imu) * share;
  lean_.mean_between_legs += (between_legs - lean_.mean_between_legs) * share;
  const Eigen::Vector2d legs = by_legs - lean_.mean_by_legs, sensor = by_imu - lean_.mean_by_imu;
  const double size = legs.norm(), other = sensor.norm();
  if (std::max(size, other) > kOnItsSoles_rad) rocked_ = true;
  const bool one_lifts = (between_legs - lean_.mean_between_legs).norm() > kOneLifts * size;
  const bool telling = size > kEnoughLean_rad && !one_lifts && other > size / kLikeAmounts &&
                       other < size * kLikeAmounts;
  const double agreement = telling ? legs.dot(sensor) / (size * other) : 0.0;
  const bool agrees = agreement > kAgreement;
  lean_.agreeing_ticks = agrees ? lean_.agreeing_ticks + 1 : 0;
  mounting_known_ = lean_.agreeing_ticks >= kContradictingTicks;
  const bool contradicts =
      telling && stood && agreement < kLeastCorrelation && !rates_agree(kVouches, kVouchingMotion);
  lean_.contradicting_ticks = contradicts ? lean_.contradicting_ticks + 1 : 0;
  return lean_.contradicting_ticks >= kContradictingTicks;
}

}  // namespace sanso::firmware
