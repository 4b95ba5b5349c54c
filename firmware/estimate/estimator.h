// The state x of the robot at every tick: orientation and rate from the IMU, joints from the
// servos, base position and velocity from a contact-aided filter (IMU acceleration, leg kinematics
// of the loaded soles, flat ground), corrected by an external pose while that is fresh. A loaded
// sole stands still; a loaded skate (settings: wheels) moves along its own x axis, its wheels lie
// on the ground, and so its z axis is the ground's normal, whatever profile that has. Fixed size;
// never waits.
#pragma once

#include <array>

#include "firmware/bus/readings.h"
#include "firmware/config/settings.h"
#include "firmware/estimate/axis_filter.h"
#include "firmware/estimate/leg_kinematics.h"
#include "firmware/exchange/samples.h"
#include "shared/model/state_layout.h"

namespace sanso::firmware {

class Estimator {
 public:
  explicit Estimator(const EstimatorSettings& settings);

  /// One tick. Until the IMU and all leg servos have been heard once, ready() is false and the
  /// state is neutral.
  const model::State& update(Nanoseconds now, const ServoReadings& servos, const ImuSample& imu,
                             const PoseSample& pose);

  /// From now on the world's x, y and heading are those of the robot at this moment.
  void set_origin_here();

  bool ready() const { return ready_; }
  /// As of the last update: base pose and velocity in the world, joints, in the order of
  /// state_layout.h.
  const model::State& state() const { return x_; }
  /// Bit 0 right, bit 1 left sole believed loaded.
  std::uint8_t contact_bits() const {
    return static_cast<std::uint8_t>((loaded_[0] ? 1 : 0) | (loaded_[1] ? 2 : 0));
  }
  /// Angular velocity of the base if the sole of this leg does not turn, base axes [rad/s].
  math::Vec3 base_rate_by_leg(Leg leg) const {
    return -sole_[static_cast<std::size_t>(leg)].w_sole_in_base;
  }
  /// Where this leg has its sole, by its joints.
  const SoleKinematics& sole(Leg leg) const { return sole_[static_cast<std::size_t>(leg)]; }
  /// Base origin above the lower foot's lowest point [m], along world z; of wheels along the normal
  /// of the ground.
  double height_above_soles() const { return height_; }
  bool on_wheels() const { return settings_.wheels; }
  /// Angle between base z and world z [rad].
  double tilt() const;
  /// Ticks since the pose in use was new; 255 = none.
  std::uint8_t pose_age_ticks() const { return pose_age_ticks_; }
  /// Finite numbers, within 100 m and 20 m/s.
  bool healthy() const;

 private:
  using Vec3 = math::Vec3;
  void read_joints(const ServoReadings& servos);
  void read_imu(const ImuSample& imu);
  void judge_contacts();
  void start_filter();
  void predict();
  void correct_by_legs();
  void correct_by_rolling(std::size_t foot, const Vec3& v_base);
  double height_by_legs() const;
  bool force_free() const;
  void correct_by_pose(Nanoseconds now, const PoseSample& pose);
  void compose_state();
  Vec3 filter_position() const;
  Vec3 filter_velocity() const;

  EstimatorSettings settings_;
  model::FootShape foot_;
  bool ready_ = false;

  // this tick's inputs
  model::Input q_ = model::Input::Zero(), dq_ = model::Input::Zero();
  math::Quat quat_world_base_ = math::quat_identity();
  math::Mat3 R_world_base_ = math::Mat3::Identity();
  Vec3 w_base_in_base_ = Vec3::Zero();
  Vec3 a_base_in_world_ = Vec3::Zero();
  std::array<SoleKinematics, 2> sole_;
  std::array<double, 2> corner_height_{};  // lowest corner relative to base origin, world z
  std::array<bool, 2> loaded_{true, true};
  double height_ = 0;

  std::array<AxisFilter, 3> axis_;

  // external pose: its frame against the filter's, and past positions to compare a late sample with
  static constexpr int kHistory = 32;
  std::array<Vec3, kHistory> past_position_{}, past_velocity_{};
  std::array<Nanoseconds, kHistory> past_time_{};
  int past_next_ = 0;
  bool pose_aligned_ = false;
  double yaw_filter_track_ = 0;
  Vec3 p_filter_track_ = Vec3::Zero();
  std::uint32_t pose_sequence_ = 0;
  std::uint8_t pose_age_ticks_ = 255;

  // the trial's world against the filter's
  double origin_yaw_ = 0;
  Vec3 origin_ = Vec3::Zero();

  model::State x_ = model::neutral_state();
};

}  // namespace sanso::firmware
