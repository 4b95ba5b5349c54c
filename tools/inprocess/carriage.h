// Where the hand at the torso is while the robot rolls: beside it along the way, across where it
// found it, and upright on the line through both axles.
#pragma once

#include <cmath>
#include <optional>

#include "shared/model/foot_shape.h"
#include "shared/model/ground.h"
#include "tools/emulator/emulated_robot.h"

namespace sanso::inprocess {

class Carriage {
 public:
  Carriage(const model::Ground& ground, double strength) : ground_(ground), strength_(strength) {}

  /// The first call finds the torso.
  emulator::Support beside(const emulator::Truth& truth) {
    if (!across_m_) across_m_ = truth.p_world_base[1];
    emulator::Support s;
    s.strength = strength_;
    s.p_world_carriage = {truth.p_world_base[0], *across_m_, truth.p_world_base[2]};
    s.quat_world_carriage =
        plant::from_rotation_vector({0.0, pitch_at(truth.p_world_base[0]), 0.0});
    return s;
  }

 private:
  /// About +y, of the line through points half a wheelbase behind and ahead.
  double pitch_at(double x) const {
    const double half = model::kSkates.half_length;
    return std::atan2(ground_height(ground_, x - half) - ground_height(ground_, x + half),
                      2.0 * half);
  }

  model::Ground ground_;
  double strength_;
  std::optional<double> across_m_;
};

}  // namespace sanso::inprocess
