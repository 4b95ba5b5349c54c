// Rotations: unit quaternions (Hamilton, w x y z in memory), exponential and logarithm, and the
// tangent operators.
// Right perturbation everywhere: q ⊕ d = q * Exp(d), d in body axes. World-frame errors are named
// as such.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace sanso::math {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
/// Quaternion components in the order w, x, y, z: the memory order of states, files and wire.
using Quat = Eigen::Vector4d;

/// Quaternions w x y z, unit: no rotation, the inverse, a after b.
inline Quat quat_identity() { return {1.0, 0.0, 0.0, 0.0}; }
inline Quat quat_conjugate(const Quat& q) { return {q[0], -q[1], -q[2], -q[3]}; }

/// Hamilton product: turns by b, then by a.
inline Quat quat_multiply(const Quat& a, const Quat& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
          a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
          a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

/// Unit length; the identity when the input is (numerically) zero.
inline Quat quat_normalized(const Quat& q) {
  const double n = q.norm();
  return n > 1e-12 ? Quat(q / n) : quat_identity();
}

/// R_A_B of quat_A_B: turns components in B into components in A.
inline Mat3 rotation_matrix(const Quat& q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  Mat3 R;
  R << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return R;
}

/// skew(v) w = v x w.
inline Mat3 skew(const Vec3& v) {
  Mat3 S;
  S << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return S;
}

/// Exp: rotation vector [rad] to quaternion. Series near zero keeps full precision.
inline Quat quat_exp(const Vec3& r) {
  const double angle2 = r.squaredNorm();
  const double angle = std::sqrt(angle2);
  const double half_sinc = angle < 1e-4 ? 0.5 - angle2 / 48.0 : std::sin(0.5 * angle) / angle;
  return {std::cos(0.5 * angle), half_sinc * r[0], half_sinc * r[1], half_sinc * r[2]};
}

/// Log: quaternion to rotation vector [rad], |r| <= pi; q and -q give the same vector (up to the
/// sign at pi).
inline Vec3 quat_log(const Quat& q_in) {
  const double sign = q_in[0] < 0 ? -1.0 : 1.0;  // the shorter way round
  const double w = sign * q_in[0];
  const Vec3 u(sign * q_in[1], sign * q_in[2], sign * q_in[3]);
  const double n = u.norm();
  const double factor = n < 1e-8 ? 2.0 / w : 2.0 * std::atan2(n, w) / n;
  return factor * u;
}

/// q ⊕ d: turned by the rotation vector d [rad] in its own axes, normalised.
inline Quat quat_plus(const Quat& q, const Vec3& d) {
  return quat_normalized(quat_multiply(q, quat_exp(d)));
}
/// a ⊖ b in body axes of b: b ⊕ (a ⊖ b) = a.
inline Vec3 quat_minus(const Quat& a, const Quat& b) {
  return quat_log(quat_multiply(quat_conjugate(b), a));
}

/// Inverse of the right Jacobian Jr of Exp, Exp(r + dr) = Exp(r) Exp(Jr(r) dr) + O(dr^2); valid for
/// |r| < 2 pi.   [Sola 2018, eq. 144]
inline Mat3 right_jacobian_inverse(const Vec3& r) {
  const double a2 = r.squaredNorm(), a = std::sqrt(a2);
  const Mat3 S = skew(r);
  if (a < 1e-4) return Mat3::Identity() + 0.5 * S + S * S / 12.0;
  return Mat3::Identity() + 0.5 * S + (1 / a2 - (1 + std::cos(a)) / (2 * a * std::sin(a))) * S * S;
}

/// Heading (rotation about world z) [rad] of a base orientation, from the direction of its x axis.
inline double yaw_of(const Quat& q) {
  return std::atan2(2 * (q[0] * q[3] + q[1] * q[2]), 1 - 2 * (q[2] * q[2] + q[3] * q[3]));
}

}  // namespace sanso::math
