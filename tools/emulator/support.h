// A hand that holds the torso while its motion is recorded: spring and damper toward a pose that
// travels along (a carriage), limited, weakened by a strength from 0 to 1.
//
//   F = strength clip(k (p_carriage - p) + d (v_carriage - v))   axes of the carriage, then world
//   T = strength clip(k_turn log(quat_carriage quat*) - d_turn w)   world
#pragma once

#include <cmath>

#include "tools/plant/plant.h"

namespace sanso::emulator {

struct Support {
  double strength = 0.0;  // 0: nobody is there
  plant::Vec3 p_world_carriage{};
  plant::Vec3 v_carriage_in_world{};
  plant::Quat quat_world_carriage{1, 0, 0, 0};
  plant::Vec3 stiffness_N_m{0.0, 300.0, 0.0};  // forward, left, up
  plant::Vec3 damping_Ns_m{0.0, 30.0, 0.0};
  double turn_Nm_rad = 5.0, turn_Nms_rad = 0.3;
  double most_N = 15.0, most_Nm = 3.0;  // a hand's limits, of the length
};

struct SupportWrench {
  plant::Vec3 force_in_world{}, torque_in_world{};
};

namespace support_detail {

inline plant::Vec3 clipped(const plant::Vec3& v, double most) {
  using plant::operator*;
  const double length = plant::norm(v);
  return length > most ? (most / length) * v : v;
}

inline plant::Vec3 rotation_vector(plant::Quat q) {
  using plant::operator*;
  if (q[0] < 0.0) q = {-q[0], -q[1], -q[2], -q[3]};
  const plant::Vec3 u{q[1], q[2], q[3]};
  const double s = plant::norm(u);
  return (s < 1e-9 ? 2.0 : 2.0 * std::atan2(s, q[0]) / s) * u;
}

}  // namespace support_detail

inline SupportWrench wrench_of(const Support& s, const plant::BaseMotion& base) {
  using plant::operator*;
  using plant::operator-;
  const plant::Quat to_carriage = plant::conjugate(s.quat_world_carriage);
  const plant::Vec3 way = plant::rotate(to_carriage, s.p_world_carriage - base.p_world_base);
  const plant::Vec3 speed =
      plant::rotate(to_carriage, s.v_carriage_in_world - base.v_base_in_world);
  plant::Vec3 force{};
  for (std::size_t i = 0; i < 3; ++i)
    force[i] = s.stiffness_N_m[i] * way[i] + s.damping_Ns_m[i] * speed[i];
  const plant::Vec3 turn = support_detail::rotation_vector(
      plant::multiply(s.quat_world_carriage, plant::conjugate(base.quat_world_base)));
  const plant::Vec3 w = plant::rotate(base.quat_world_base, base.w_base_in_base);
  const plant::Vec3 torque = s.turn_Nm_rad * turn - s.turn_Nms_rad * w;
  return {
      s.strength * plant::rotate(s.quat_world_carriage, support_detail::clipped(force, s.most_N)),
      s.strength * support_detail::clipped(torque, s.most_Nm)};
}

}  // namespace sanso::emulator
