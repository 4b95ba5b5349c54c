// From the emulated world's frame to the reference's: the robot stood at the reference's first
// position and heading when the trial began.
#pragma once

#include <array>

#include "host/learn/episodes/episode.h"

namespace sanso::inprocess {

class TruthFrame {
 public:
  /// `first`: the true state (order of the state layout, world frame) at the beginning of the
  /// trial.
  TruthFrame(const std::array<double, model::kNx>& first,
             const std::array<float, model::kNx>& first_reference);
  /// The true state in the reference's frame, with the normal forces under right and left foot [N]
  /// and how far their soles are from the ground below [m].
  learn::TrueSample sample(const std::array<double, model::kNx>& world,
                           const std::array<double, 2>& foot_load_N,
                           const std::array<double, 2>& foot_clearance_m) const;

 private:
  math::Quat quat_ref_world_ = math::quat_identity();
  math::Vec3 p_ref_world_ = math::Vec3::Zero();
};

}  // namespace sanso::inprocess
