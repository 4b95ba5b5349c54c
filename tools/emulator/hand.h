// A hand behind the torso: keeps a robot on wheels from rolling away until its trial begins, pushes
// it off, and lets go. A spring and a damper along the heading to a point that the hand moves;
// across, up and down and in all rotations the robot is by itself.
#pragma once

#include <algorithm>

#include "shared/base/time.h"
#include "tools/plant/plant.h"

namespace sanso::emulator {

/// How the hand starts the robot: over `push_s` evenly from rest to `push_m_s`; 0 m/s: it only lets
/// go then.
struct Push {
  double push_m_s = 0.0, push_s = 0.0;
};

class Hand {
 public:
  /// Holds the torso where it is from the first moment in which nobody else does.
  void lend(const Push& push) { push_ = push, there_ = true, gone_ = begun_ = caught_ = false; }
  bool there() const { return there_ && !gone_; }
  /// Begins the push; nothing without a hand, or once it has begun.
  void push_off(Nanoseconds now) {
    if (there() && !begun_) begun_ = true, begin_ = now;
  }

  /// Force on the torso [N], world axes. `free`: nobody else holds the robot.
  plant::Vec3 force(Nanoseconds now, const plant::BaseMotion& base, bool free) {
    using plant::operator*;
    if (!there() || !free) return {};
    const plant::Vec3 forward = plant::rotate(base.quat_world_base, {1, 0, 0});
    const auto along = [&](const plant::Vec3& v) {
      return v[0] * forward[0] + v[1] * forward[1] + v[2] * forward[2];
    };
    if (!caught_) caught_ = true, held_ = base.p_world_base;
    const double t = begun_ ? to_seconds(now - begin_) : 0.0;
    if (begun_ && t >= push_.push_s) {
      gone_ = true;
      return {};
    }
    const double speed = begun_ ? push_.push_m_s * t / push_.push_s : 0.0;
    const plant::Vec3 way = {base.p_world_base[0] - held_[0], base.p_world_base[1] - held_[1],
                             base.p_world_base[2] - held_[2]};
    return (kStiffness_N_m * (0.5 * speed * t - along(way)) +
            kDamping_Ns_m * (speed - along(base.v_base_in_world))) *
           forward;
  }

 private:
  static constexpr double kStiffness_N_m = 300.0, kDamping_Ns_m = 30.0;  // a soft grip

  Push push_;
  bool there_ = false, caught_ = false, begun_ = false, gone_ = false;
  Nanoseconds begin_ = 0;
  plant::Vec3 held_{};  // where the hand found the torso
};

}  // namespace sanso::emulator
