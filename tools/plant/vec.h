// Plain vectors and quaternions of the emulated world. Deliberately not shared/math: the plant
// shares no formula with the controller. Quaternions are Hamilton, w x y z; quat_world_base turns
// base components into world.
#pragma once

#include <array>
#include <cmath>

namespace sanso::plant {

using Vec3 = std::array<double, 3>;
using Quat = std::array<double, 4>;

inline constexpr double kPi = 3.14159265358979323846;

inline Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vec3 operator*(double s, const Vec3& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }

/// Hamilton product: turns by b, then by a.
inline Quat multiply(const Quat& a, const Quat& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
          a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
          a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}
inline Quat conjugate(const Quat& q) { return {q[0], -q[1], -q[2], -q[3]}; }
/// Turns v by q: components in the inner frame to the outer one.
inline Vec3 rotate(const Quat& q, const Vec3& v) {
  const Vec3 u{q[1], q[2], q[3]};
  const Vec3 t = 2.0 * cross(u, v);
  return v + q[0] * t + cross(u, t);
}
/// Rotation by |r| [rad] about r.
inline Quat from_rotation_vector(const Vec3& r) {
  const double angle = norm(r);
  const double s = angle < 1e-9 ? 0.5 : std::sin(0.5 * angle) / angle;
  return {std::cos(0.5 * angle), s * r[0], s * r[1], s * r[2]};
}

}  // namespace sanso::plant
