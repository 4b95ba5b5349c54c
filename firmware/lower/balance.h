// A small posture feedback for holding and stopping, when no upper layer balances the robot: ankles
// answer to the lean of the trunk against that of the pose and to its rate, as in the maker's
// walking module. Off while its gains are 0.
#pragma once

#include "firmware/config/settings.h"
#include "shared/math/so3.h"
#include "shared/model/state_layout.h"

namespace sanso::firmware {

/// Lean of a trunk [rad]; heading does not count.
struct Lean {
  double pitch = 0.0;  // forward, about +y
  double roll = 0.0;   // to the right, about +x
};

/// Of the base at x, against world z.
inline Lean lean_of(const model::State& x) {
  const math::Mat3 R_world_base = math::rotation_matrix(model::base_quat(x));
  return {std::atan2(-R_world_base(2, 0), R_world_base(2, 2)),
          std::atan2(R_world_base(2, 1), R_world_base(2, 2))};
}

/// Change of the target angles [rad] for a robot at x whose pose leans by `pose`. Signs: trunk
/// further forward than the pose -> toes press down (l_ank_pitch falls, r_ank_pitch rises); further
/// to the right -> ank_roll of both feet rises, so that the right edge presses down.
inline model::Input balance_correction(const model::State& x, const Lean& pose,
                                       const SupervisorSettings& s) {
  const Lean lean = lean_of(x);
  const double forward = s.balance_pitch_gain * (lean.pitch - pose.pitch) +
                         s.balance_pitch_rate_s * x[model::kXOmega + 1];
  const double right =
      s.balance_roll_gain * (lean.roll - pose.roll) + s.balance_roll_rate_s * x[model::kXOmega];
  constexpr int kRightAnkPitch = 4, kRightAnkRoll = 5, kLeftAnkPitch = 10, kLeftAnkRoll = 11;
  model::Input u = model::Input::Zero();
  u[kRightAnkPitch] = forward;
  u[kLeftAnkPitch] = -forward;
  u[kRightAnkRoll] = right;
  u[kLeftAnkRoll] = right;
  return u;
}

}  // namespace sanso::firmware
