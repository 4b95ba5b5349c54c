// Every passage is a blend from the present pose to the next, as long as the settings say; the
// weights of middle layer and balance move by at most one tick's share at a time.
#include "firmware/app/posture.h"

#include <algorithm>
#include <cmath>

#include "firmware/lower/balance.h"

namespace sanso::firmware {
namespace {

constexpr double kBalanceRamp_s = 0.2;
// a newly uploaded first pose is approached at this speed while holding
constexpr double kPoseRate_rad_s = 0.5;
// arms and head reach their pose no faster
constexpr double kHeldRate_rad_s = 1.2;
constexpr double kPeakOfMinimumJerk = 1.875;  // largest speed against the mean speed

/// Moves `weight` towards `goal` by at most one tick's share of `ramp_s`.
void ramp(double& weight, double goal, double ramp_s) {
  const double step = ramp_s > kTick_s ? kTick_s / ramp_s : 1.0;
  weight += std::clamp(goal - weight, -step, step);
}

}  // namespace

model::Input crouch_pose() {
  // right hip_yaw, hip_roll, hip_pitch, knee, ank_pitch, ank_roll; left mirrored: q_left = -q_right
  constexpr double kThigh = 60.0 * kRadPerDeg;
  // trunk forward: brings the weight over the soles when the servos sag
  constexpr double kLean = 10.8 * kRadPerDeg;
  model::Input q = model::Input::Zero();
  q[2] = kThigh + kLean;
  q[3] = -2.0 * kThigh;
  q[4] = -kThigh;
  for (int j = 0; j < 6; ++j) q[6 + j] = -q[j];
  return q;
}

void Posture::begin_stand_up(const ServoGoals& goals, const model::Input& first_pose) {
  through_crouch_ = longest_way(goals.legs - first_pose) > settings_.near_pose_rad;
  lowering_ = false;
  held_ = first_pose;
  middle_weight_ = balance_weight_ = 0;
  const double duration = through_crouch_ ? settings_.stand_up_s : settings_.approach_s;
  blend_.start(goals.legs, duration);
  held_from_ = goals.held;
  double way = 0;
  for (std::size_t k = 0; k < kNumHeld; ++k)
    way = std::max(way, std::abs(kHeldServos[k].pose_rad - held_from_[k]));
  held_fraction_ = 0;
  held_step_ = kTick_s / std::max(duration, kPeakOfMinimumJerk * way / kHeldRate_rad_s);
}

void Posture::begin_hold(const ServoGoals& goals) {
  lowering_ = through_crouch_ = false;
  held_ = goals.legs;
  middle_weight_ = balance_weight_ = 0;
  blend_.start(goals.legs, kTick_s);
  held_from_ = goals.held;
  held_fraction_ = 1;
}

void Posture::begin_soft_stop(const model::Input& output) {
  lowering_ = through_crouch_ = false;
  blend_.start(output, settings_.soft_stop_s);
}

void Posture::begin_lowering(const model::Input& output) {
  lowering_ = true;
  through_crouch_ = false;
  blend_.start(output, settings_.lower_s);
  held_fraction_ = 1;
}

void Posture::begin_tuck(const model::Input& output, double duration_s) {
  begin_lowering(output);
  blend_.start(output, duration_s);
}

/// All joints arrive together: on the way the soles stay as parallel as at both ends.
void Posture::follow_first_pose(const model::Input& first_pose) {
  const double step = kPoseRate_rad_s * kTick_s;
  const model::Input way = first_pose - held_;
  const double longest = longest_way(way);
  if (longest <= step)
    held_ = first_pose;
  else
    held_ += (step / longest) * way;
}

model::Input Posture::hold_target(Trial& trial, const model::State& x) {
  if (trial.has_primitives()) follow_first_pose(trial.first_pose());
  ramp(middle_weight_, 1.0, settings_.middle_ramp_s);
  ramp(balance_weight_, 1.0, kBalanceRamp_s);
  return held_ + middle_weight_ * trial.middle_at_start(x) + trial.reflex(x) + balance(trial, x);
}

model::Input Posture::step(Trial& trial, const model::State& x) {
  held_fraction_ = std::min(1.0, held_fraction_ + held_step_);
  if (lowering_ || through_crouch_) {
    model::Input u = blend_.step(crouch_pose());
    if (through_crouch_ && blend_.done()) {
      through_crouch_ = false;
      blend_.start(u, settings_.stand_up_s);
    }
    return u;
  }
  return blend_.step(hold_target(trial, x));
}

std::array<double, kNumHeld> Posture::held_targets() const {
  std::array<double, kNumHeld> targets{};
  const double s = minimum_jerk(held_fraction_);
  for (std::size_t k = 0; k < kNumHeld; ++k)
    targets[k] = held_from_[k] + s * (kHeldServos[k].pose_rad - held_from_[k]);
  return targets;
}

model::Input Posture::fade_balance(const Trial& trial, const model::State& x) {
  middle_weight_ = 1.0;
  ramp(balance_weight_, 0.0, kBalanceRamp_s);
  return balance(trial, x);
}

/// How a robot without an uploaded motion is meant to lean, nobody has said.
model::Input Posture::balance(const Trial& trial, const model::State& x) const {
  if (balance_weight_ == 0.0 || !trial.has_primitives()) return model::Input::Zero();
  return balance_weight_ * balance_correction(x, trial.first_lean(), settings_);
}

}  // namespace sanso::firmware
