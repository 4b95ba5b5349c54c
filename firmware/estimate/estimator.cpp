// Per tick and in this order: joints, IMU, contacts, prediction, correction by loaded legs,
// correction by the pose sample, state.
#include "firmware/estimate/estimator.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace sanso::firmware {
namespace {

using math::Mat3;
using math::Vec3;
using Vec4 = AxisFilter::Vec4;

constexpr double kStartSigma = 0.02;  // m and m/s: a robot at rest
// a larger innovation is a jump of the tracker, not of the robot
constexpr double kPoseJump_m = 0.15;
// share of the tracker's height error removed at each sample while standing
constexpr double kHeightFollow = 0.05;
constexpr double kFree_m_s2 =
    3.0;  // on the ground it is gravity, in a jolt for a tick perhaps less
constexpr int kMaxExtrapolatedTicks = 3;  // beyond that a silent servo's angle is held

Mat3 yaw_rotation(double yaw) {
  Mat3 R = Mat3::Identity();
  R(0, 0) = R(1, 1) = std::cos(yaw);
  R(1, 0) = std::sin(yaw);
  R(0, 1) = -R(1, 0);
  return R;
}

Vec4 unit(int index) { return Vec4::Unit(index); }

}  // namespace

Estimator::Estimator(const EstimatorSettings& settings)
    : settings_(settings), foot_(settings.wheels ? model::kSkates : model::kSoles) {}

const model::State& Estimator::update(Nanoseconds now, const ServoReadings& servos,
                                      const ImuSample& imu, const PoseSample& pose) {
  const bool heard =
      imu.time != 0 && std::all_of(servos.servo.begin(), servos.servo.begin() + model::kNumJoints,
                                   [](const ServoReading& r) { return r.known; });
  if (!heard) return x_;
  read_joints(servos);
  read_imu(imu);
  judge_contacts();
  if (!ready_) start_filter();
  predict();
  correct_by_legs();
  correct_by_pose(now, pose);
  past_position_[static_cast<std::size_t>(past_next_)] = filter_position();
  past_velocity_[static_cast<std::size_t>(past_next_)] = filter_velocity();
  past_time_[static_cast<std::size_t>(past_next_)] = now;
  past_next_ = (past_next_ + 1) % kHistory;
  compose_state();
  return x_;
}

void Estimator::read_joints(const ServoReadings& servos) {
  const double keep = settings_.joint_rate_filter_s / (settings_.joint_rate_filter_s + kTick_s);
  for (int j = 0; j < model::kNumJoints; ++j) {
    const ServoReading& r = servos.servo[static_cast<std::size_t>(j)];
    if (r.age_ticks == 0) {
      q_[j] = r.position_rad;
      dq_[j] = keep * dq_[j] + (1.0 - keep) * r.velocity_rad_s;
    } else if (r.age_ticks <= kMaxExtrapolatedTicks) {
      q_[j] = r.position_rad + r.age_ticks * kTick_s * r.velocity_rad_s;
    } else {
      dq_[j] = 0.0;
    }
  }
}

void Estimator::read_imu(const ImuSample& imu) {
  quat_world_base_ = math::quat_normalized(imu.quat_world_base);
  R_world_base_ = math::rotation_matrix(quat_world_base_);
  w_base_in_base_ = imu.gyro;
  a_base_in_world_ = R_world_base_ * imu.accel - Vec3(0, 0, kGravity);
}

void Estimator::judge_contacts() {
  for (const Leg leg : {kRightLeg, kLeftLeg}) {
    const auto i = static_cast<std::size_t>(leg);
    sole_[i] = sole_kinematics(leg, q_.data() + leg * kJointsPerLeg,
                               dq_.data() + leg * kJointsPerLeg, foot_);
  }
  Vec3 up_in_base = R_world_base_.row(2);
  if (settings_.wheels)
    up_in_base = (sole_[0].R_base_sole.col(2) + sole_[1].R_base_sole.col(2)).normalized();
  for (std::size_t i = 0; i < 2; ++i)
    corner_height_[i] = lowest_corner(sole_[i], up_in_base, foot_);
  const double ground = std::min(corner_height_[0], corner_height_[1]);
  height_ = -ground;
  if (force_free()) {  // in the air; legs tell only which foot is lower
    loaded_.fill(false);
    return;
  }
  for (std::size_t i = 0; i < 2; ++i) {
    // hysteresis: a loaded sole has to rise half as far again before it counts as lifted
    const double threshold = settings_.contact_height_m * (loaded_[i] ? 1.5 : 1.0);
    loaded_[i] = corner_height_[i] - ground < threshold;
  }
}

/// The IMU feels next to nothing.
bool Estimator::force_free() const {
  return (a_base_in_world_ + Vec3(0, 0, kGravity)).norm() < kFree_m_s2;
}

/// Of the base above the ground where the feet are [m], along world z.
double Estimator::height_by_legs() const {
  if (!settings_.wheels) return height_;
  return -0.5 * R_world_base_.row(2).dot(sole_[0].p_base_sole + sole_[1].p_base_sole);
}

void Estimator::start_filter() {
  const Vec3 p(0.0, 0.0, height_by_legs());
  const Vec3 right = p + R_world_base_ * sole_[0].p_base_sole,
             left = p + R_world_base_ * sole_[1].p_base_sole;
  for (int a = 0; a < 3; ++a)
    axis_[static_cast<std::size_t>(a)].reset(p[a], right[a], left[a], kStartSigma);
  past_position_.fill(p);
  past_velocity_.fill(Vec3::Zero());
  ready_ = true;
}

void Estimator::predict() {
  const bool right_stands = loaded_[0] && !settings_.wheels;
  const bool left_stands = loaded_[1] && !settings_.wheels;
  const double right = right_stands ? settings_.foot_slip_noise : settings_.foot_swing_noise;
  const double left = left_stands ? settings_.foot_slip_noise : settings_.foot_swing_noise;
  for (int a = 0; a < 3; ++a)
    axis_[static_cast<std::size_t>(a)].predict(a_base_in_world_[a], kTick_s, settings_.accel_noise,
                                               right, left);
}

void Estimator::correct_by_legs() {
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec3 p_base_sole_in_world = R_world_base_ * sole_[i].p_base_sole;
    // a loaded sole stands still: 0 = v_base + R (w x p + v_sole)
    const Vec3 v_base = -(R_world_base_ * (math::skew(w_base_in_base_) * sole_[i].p_base_sole +
                                           sole_[i].v_sole_in_base));
    const int sole = AxisFilter::kRightSole + static_cast<int>(i);
    for (int a = 0; a < 3; ++a) {
      AxisFilter& axis = axis_[static_cast<std::size_t>(a)];
      axis.measure(unit(sole) - unit(AxisFilter::kPosition), p_base_sole_in_world[a],
                   settings_.foot_position_noise_m);
      if (loaded_[i] && !settings_.wheels)
        axis.measure(unit(AxisFilter::kVelocity), v_base[a], settings_.foot_velocity_noise);
    }
    if (loaded_[i] && settings_.wheels) correct_by_rolling(i, v_base);
    if (loaded_[i] && settings_.flat_ground)
      axis_[2].measure(unit(AxisFilter::kPosition),
                       settings_.wheels ? -p_base_sole_in_world[2] : -corner_height_[i],
                       settings_.foot_position_noise_m);
  }
}

/// A loaded skate moves neither across its wheels nor away from the ground; along them it tells
/// nothing. `v_base`: velocity of the base if it stood still.
void Estimator::correct_by_rolling(std::size_t foot, const Vec3& v_base) {
  const auto velocity = unit(AxisFilter::kVelocity);
  const Mat3 R_world_sole = R_world_base_ * sole_[foot].R_base_sole;
  for (const int held : {1, 2}) {
    const Vec3 direction = R_world_sole.col(held);
    double S = settings_.foot_velocity_noise * settings_.foot_velocity_noise;
    for (int a = 0; a < 3; ++a)
      S += direction[a] * direction[a] * axis_[static_cast<std::size_t>(a)].variance(velocity);
    const double innovation = direction.dot(v_base - filter_velocity());
    for (int a = 0; a < 3; ++a)
      axis_[static_cast<std::size_t>(a)].correct_share(direction[a] * velocity, innovation, S);
  }
}

void Estimator::correct_by_pose(Nanoseconds now, const PoseSample& pose) {
  if (pose_age_ticks_ < 255) ++pose_age_ticks_;
  const bool fresh = pose.time != 0 && pose.sequence != pose_sequence_;
  if (!fresh || pose.confidence < settings_.pose_min_confidence) return;
  pose_sequence_ = pose.sequence;
  const Nanoseconds age = now - pose.time;
  if (age > from_seconds(settings_.pose_max_age_s)) return;
  pose_age_ticks_ = static_cast<std::uint8_t>(std::clamp<Nanoseconds>(age / kTickPeriod, 0, 254));

  // where the filter believed to be, and how fast, when the pose was taken
  Vec3 p_then = filter_position(), v_then = filter_velocity();
  Nanoseconds nearest = age < 0 ? -age : age;
  for (std::size_t k = 0; k < past_time_.size(); ++k) {
    const Nanoseconds distance =
        past_time_[k] > pose.time ? past_time_[k] - pose.time : pose.time - past_time_[k];
    if (past_time_[k] != 0 && distance < nearest) {
      nearest = distance;
      p_then = past_position_[k];
      v_then = past_velocity_[k];
    }
  }
  const Vec3 in_track = yaw_rotation(yaw_filter_track_) * pose.p_track_base;
  Vec3 innovation = p_filter_track_ + in_track - p_then;
  if (!pose_aligned_ || innovation.norm() > kPoseJump_m) {
    yaw_filter_track_ = math::yaw_of(quat_world_base_) - math::yaw_of(pose.quat_track_base);
    p_filter_track_ = p_then - yaw_rotation(yaw_filter_track_) * pose.p_track_base;
    pose_aligned_ = true;
    innovation = Vec3::Zero();
  }
  if (settings_.flat_ground && loaded_[0] && loaded_[1]) {
    // standing on known ground the legs know the height: the tracker's offset follows them
    const double wrong = p_filter_track_[2] + in_track[2] - height_;
    p_filter_track_[2] -= kHeightFollow * wrong;
    innovation[2] -= kHeightFollow * wrong;
  }
  const Vec3 v = yaw_rotation(yaw_filter_track_) * pose.v_base_in_track;
  for (int a = 0; a < 3; ++a) {
    AxisFilter& axis = axis_[static_cast<std::size_t>(a)];
    axis.correct(unit(AxisFilter::kPosition), innovation[a], settings_.pose_noise_m);
    axis.correct(unit(AxisFilter::kVelocity), v[a] - v_then[a], settings_.pose_velocity_noise);
  }
}

Vec3 Estimator::filter_position() const {
  return {axis_[0].position(), axis_[1].position(), axis_[2].position()};
}

Vec3 Estimator::filter_velocity() const {
  return {axis_[0].velocity(), axis_[1].velocity(), axis_[2].velocity()};
}

void Estimator::set_origin_here() {
  if (!ready_) return;
  origin_ = Vec3(axis_[0].position(), axis_[1].position(), 0.0);
  // a profile is at height 0 where the robot starts, and nothing else tells its height
  if (settings_.wheels && !settings_.flat_ground)
    origin_[2] = axis_[2].position() - height_by_legs();
  origin_yaw_ = math::yaw_of(quat_world_base_);
  compose_state();
}

void Estimator::compose_state() {
  const Mat3 R_trial_filter = yaw_rotation(-origin_yaw_);
  const math::Quat quat_trial_filter(std::cos(0.5 * origin_yaw_), 0.0, 0.0,
                                     -std::sin(0.5 * origin_yaw_));
  const Vec3 v = filter_velocity();
  x_.segment<3>(model::kXPos) = R_trial_filter * (filter_position() - origin_);
  x_.segment<4>(model::kXQuat) =
      math::quat_normalized(math::quat_multiply(quat_trial_filter, quat_world_base_));
  x_.segment<model::kNumJoints>(model::kXJoint) = q_;
  x_.segment<3>(model::kXVel) = R_trial_filter * v;
  x_.segment<3>(model::kXOmega) = w_base_in_base_;
  x_.segment<model::kNumJoints>(model::kXJointRate) = dq_;
}

double Estimator::tilt() const { return std::acos(std::clamp(R_world_base_(2, 2), -1.0, 1.0)); }

bool Estimator::healthy() const {
  return x_.allFinite() && x_.segment<3>(model::kXPos).norm() < 100.0 &&
         x_.segment<3>(model::kXVel).norm() < 20.0;
}

}  // namespace sanso::firmware
