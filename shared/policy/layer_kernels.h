// The arithmetic of the layer sum, once for doubles and for SIMD packs: templates over the scalar.
// No Eigen, so that the files that are built per instruction set may include it.
#pragma once

#include "shared/model/dimensions.h"

namespace sanso::policy {

/// u + K dx, column by column so that the order of additions is the same for every scalar (double
/// or a SIMD pack).
/// Shapes  u, out (nu); K (nu x ndx) row by row through K(i, j); dx (ndx).     Unit  rad
template <class U, class K, class Dx, class Out>
inline void affine_kernel(const U& u, const K& gain, const Dx& dx, Out& out) {
  for (int i = 0; i < model::kNu; ++i) out[i] = u[i];
  for (int j = 0; j < model::kNdx; ++j)
    for (int i = 0; i < model::kNu; ++i) out[i] = out[i] + gain(i, j) * dx[j];
}

/// Settings of the stretch reflex (paper: gain 0.1, sigmoid gain a = 10).
struct ReflexSettings {
  double gain = 0.1;        // K_r [rad]
  double sharpness = 10.0;  // a [1/rad]
};

/// zeta_a(d) = 1 / (1 + exp(-a d)): 0 beyond a limit (d < 0), 1/2 at it, 1 well inside. d: distance
/// to the limit [rad].
/// `exp_of` is the scalar's exponential, so that SIMD packs can bring their own. Its complement is
/// 1 - zeta(d) = zeta(-d), exact where 1 - zeta(d) would lose digits.
template <class Scalar, class Exp>
inline Scalar zeta(const Scalar& distance, double sharpness, Exp exp_of) {
  return Scalar(1.0) / (Scalar(1.0) + exp_of(Scalar(-sharpness) * distance));
}

/// K_r (zeta(q_max - q) - zeta(q - q_min)): change of the target angle [rad] that keeps a joint
/// away from its limits.
/// Sign, checked against the physics: a servo pulls q towards its target, so at q_max the target
/// has to fall. There zeta(q_max - q) = 1/2 and zeta(q - q_min) is nearly 1: the sum is -K_r/2,
/// away from the limit. At q_min: +K_r/2.
/// In the middle of the range both are nearly 1 and cancel.
template <class Scalar, class Exp>
inline Scalar reflex_kernel(const Scalar& q, double q_min, double q_max, const ReflexSettings& s,
                            Exp exp_of) {
  const Scalar to_upper = zeta(Scalar(q_max) - q, s.sharpness, exp_of);
  const Scalar to_lower = zeta(q - Scalar(q_min), s.sharpness, exp_of);
  return Scalar(s.gain) * (to_upper - to_lower);
}

/// The same change, written with the complements: K_r (zeta(q_min - q) - zeta(q - q_max)). Inside
/// the range both are nearly 0 and keep all their digits, which the planner's differences need; the
/// controller executes reflex_kernel, the same number to rounding. Neither may replace the other:
/// recorded trials are compared bit by bit.
template <class Scalar, class Exp>
inline Scalar reflex_complement_kernel(const Scalar& q, double q_min, double q_max,
                                       const ReflexSettings& s, Exp exp_of) {
  const Scalar below = zeta(Scalar(q_min) - q, s.sharpness, exp_of);
  const Scalar above = zeta(q - Scalar(q_max), s.sharpness, exp_of);
  return Scalar(s.gain) * (below - above);
}

}  // namespace sanso::policy
