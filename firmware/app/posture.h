// The slow motions: standing up, holding the first pose, stopping softly, lowering. All are
// passages from where the robot is to a pose that may itself move a little (reflex, middle layer,
// balance).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "firmware/app/trial.h"
#include "firmware/bus/readings.h"
#include "firmware/config/settings.h"
#include "firmware/lower/pose_blend.h"

namespace sanso::firmware {

/// Deep crouch with the soles under the hips, knees inside their limit: the way from and to torque
/// off [rad].
model::Input crouch_pose();

/// Targets of all servos [rad].
struct ServoGoals {
  model::Input legs = model::Input::Zero();
  std::array<double, kNumHeld> held{};
};

/// The way of the joint that has farthest to go [rad]. Eigen's maximum calls a function by pointer,
/// of which no compiler can tell that it does not wait.
inline double longest_way(const model::Input& way) {
  double longest = 0;
  for (int j = 0; j < model::kNumJoints; ++j) longest = std::max(longest, std::abs(way[j]));
  return longest;
}

class Posture {
 public:
  explicit Posture(const SupervisorSettings& settings) : settings_(settings) {}

  /// From the servos' `goals` to the first pose: straight when near it, through the crouch when
  /// not. Arms and head take the time they need.
  void begin_stand_up(const ServoGoals& goals, const model::Input& first_pose);
  /// Stays where the servos' goals are.
  void begin_hold(const ServoGoals& goals);
  /// From the targets sent last to the first pose.
  void begin_soft_stop(const model::Input& output);
  /// From the targets sent last into the crouch; quickly: as far as the robot gets in a fall.
  void begin_lowering(const model::Input& output);
  void begin_tuck(const model::Input& output, double duration_s);

  /// Targets of this tick for a robot at x.
  model::Input step(Trial& trial, const model::State& x);
  /// The passage has reached its pose.
  bool arrived() const { return blend_.done() && !through_crouch_ && held_fraction_ > 1.0 - 1e-9; }
  bool lowering() const { return lowering_; }
  /// The pose held is the one in which the uploaded motion begins.
  bool at_first_pose(const model::Input& first_pose) const {
    return longest_way(held_ - first_pose) < 1e-9;
  }

  /// Targets for arms and head [rad], moving to their pose during stand-up.
  std::array<double, kNumHeld> held_targets() const;
  /// Called once a tick while a trial runs: balance feedback gives way to the upper layer.
  model::Input fade_balance(const Trial& trial, const model::State& x);

 private:
  model::Input hold_target(Trial& trial, const model::State& x);
  model::Input balance(const Trial& trial, const model::State& x) const;
  void follow_first_pose(const model::Input& first_pose);

  SupervisorSettings settings_;
  PoseBlend blend_;
  bool lowering_ = false;
  bool through_crouch_ = false;
  model::Input held_ = model::Input::Zero();
  double middle_weight_ = 0;
  double balance_weight_ = 0;
  std::array<double, kNumHeld> held_from_{};
  double held_fraction_ = 1;
  double held_step_ = 1;
};

}  // namespace sanso::firmware
