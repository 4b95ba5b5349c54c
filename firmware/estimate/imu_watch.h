// Does the IMU tell of this robot? Its specific force is compared with gravity, its rate with its
// own orientation, and both with what the legs say while the soles stand on the ground. Finds wrong
// units, swapped or turned axes, wrong mounting and jumps; silence and frozen samples are the
// guard's.
#pragma once

#include "firmware/config/settings.h"
#include "firmware/estimate/estimator.h"
#include "firmware/exchange/samples.h"

namespace sanso::firmware {

class ImuWatch {
 public:
  enum Reason : std::uint8_t {
    kPlausible = 0,
    kOtherGravity = 1,  // the mean specific force is not 9.81 m/s^2 upwards
    kRate = 2,          // the orientation does not turn as the gyro says
    kAgainstLegs = 3    // the trunk turns another way than the legs on the ground turn it
  };

  explicit ImuWatch(const ImuSettings& settings) : settings_(settings) {}
  void reset() { *this = ImuWatch(settings_); }

  /// Once a tick, after the estimator. `standing`: the servos carry the robot.
  void update(Nanoseconds now, const ImuSample& imu, const Estimator& estimator, bool standing);
  /// Why the IMU cannot be believed at the moment.
  Reason reason() const { return reason_; }

 private:
  bool gravity_wrong(double dt, const ImuSample& imu);
  bool rate_wrong(double dt, const ImuSample& imu);
  bool legs_contradict(double dt, const ImuSample& imu, const Estimator& estimator);
  bool rates_agree(double correlation, double motion) const;
  bool leans_another_way(double dt, const ImuSample& imu, const Estimator& estimator);

  ImuSettings settings_;
  Reason reason_ = kPlausible;
  ImuSample last_;
  double heard_s_ = 0;
  math::Vec3 mean_force_in_world_ = math::Vec3::Zero();
  math::Vec3 drift_in_base_ = math::Vec3::Zero();      // orientation ahead of the gyro  rad
  double legs_legs_ = 0, imu_imu_ = 0, legs_imu_ = 0;  // fading sums of products  rad^2/s
  int contradicting_ticks_ = 0;

  /// Two accounts of the lean since the soles lie on one plane: x and y of the vertical, base axes.
  struct Lean {
    bool begun = false;
    double stood_s = 0;  // on one plane without a break
    Eigen::Vector2d mean_by_legs = Eigen::Vector2d::Zero(), mean_by_imu = Eigen::Vector2d::Zero();
    Eigen::Vector2d mean_between_legs = Eigen::Vector2d::Zero();  // how they differ about it
    int agreeing_ticks = 0, contradicting_ticks = 0;
  };
  Lean lean_;
  bool rocked_ = false;          // the lean was larger than soles on the ground allow
  bool mounting_known_ = false;  // the two have agreed over a lean that was large enough to tell
};

}  // namespace sanso::firmware
