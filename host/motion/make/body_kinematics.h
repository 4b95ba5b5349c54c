// Where the masses and the feet of the OP3 are in a configuration: what retargeting and its checks
// need, no more.
#pragma once

#include <array>

#include "host/motion/mocap/human_motion.h"
#include "shared/model/op3_table.h"
#include "shared/model/state_layout.h"

namespace sanso::motion {

struct BodyPoints {
  std::array<math::Vec3, model::kNumBodies> p_world_com;  // centre of mass of each body   m
  // origin of the ankle-roll frame, right and left   m
  std::array<math::Vec3, 2> p_world_foot;
  std::array<math::Mat3, 2> R_world_foot;
  // joint origins down the leg, then the foot: for figures
  std::array<std::array<math::Vec3, 7>, 2> leg;

  /// Of all bodies together, world axes, m.
  math::Vec3 centre_of_mass() const;
  /// Sole corners of a foot, world axes: front outer, back outer, back inner, front inner.
  std::array<math::Vec3, 4> sole_corners(int side) const;
  /// World height of a sole's lowest corner, m.
  double sole_height(int side) const;
};

/// Forward kinematics of base pose and joints (velocities in x are not looked at).
BodyPoints body_points(const model::State& x);

}  // namespace sanso::motion
