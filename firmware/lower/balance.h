// A small posture feedback for holding and stopping, when no upper layer balances the robot: ankles
// answer to the tilt of the trunk and to its rate, as in the maker's walking module. Off (zero
// gains) by default values of 0.
#pragma once

#include "firmware/config/settings.h"
#include "shared/math/so3.h"
#include "shared/model/state_layout.h"

namespace sanso::firmware {

/// Change of the target angles [rad]. Signs: trunk pitched forward (about +y) -> toes press down
/// (l_ank_pitch falls, r_ank_pitch rises); trunk rolled to the right (about +x) -> ank_roll of both
/// feet rises, so that the right edge presses down.
inline model::Input balance_correction(const model::State& x, const SupervisorSettings& s) {
  const math::Mat3 R_world_base = math::rotation_matrix(model::base_quat(x));
  const double pitch = std::atan2(-R_world_base(2, 0), R_world_base(2, 2));
  const double roll = std::atan2(R_world_base(2, 1), R_world_base(2, 2));
  const double forward =
      s.balance_pitch_gain * pitch + s.balance_pitch_rate_s * x[model::kXOmega + 1];
  const double right = s.balance_roll_gain * roll + s.balance_roll_rate_s * x[model::kXOmega];
  constexpr int kRightAnkPitch = 4, kRightAnkRoll = 5, kLeftAnkPitch = 10, kLeftAnkRoll = 11;
  model::Input u = model::Input::Zero();
  u[kRightAnkPitch] = forward;
  u[kLeftAnkPitch] = -forward;
  u[kRightAnkRoll] = right;
  u[kLeftAnkRoll] = right;
  return u;
}

}  // namespace sanso::firmware
