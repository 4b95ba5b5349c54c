// The low-level sum of the layers: u = u_up + K_up (x ⊖ x_up) + u_mid + K_mid (x ⊖ x_mid) + u_low,
// with first-order hold between knots. One implementation: the controller executes it every 10 ms,
// the host predicts with it, and without its upper terms it is what the noise term F needs. No
// heap; kernels are templates over the scalar.
#pragma once

#include <algorithm>
#include <cmath>

#include "shared/model/joints.h"
#include "shared/policy/policy_types.h"

namespace sanso::policy {

// --- kernels -------------------------------------------------------------------------------------

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
/// `exp_of` is the scalar's exponential, so that SIMD packs can bring their own.
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

/// The reflex of all joints at joint angles q. Unit rad.
inline model::Input reflex(const model::State& x, const ReflexSettings& s = {}) {
  model::Input u;
  for (int j = 0; j < model::kNumJoints; ++j) {
    const model::JointInfo& joint = model::kJoints[static_cast<std::size_t>(j)];
    u[j] = reflex_kernel<double>(x[model::kXJoint + j], joint.lower_rad, joint.upper_rad, s,
                                 [](double v) { return std::exp(v); });
  }
  return u;
}

// --- first-order hold ----------------------------------------------------------------------------

/// Knot between a (s = 0) and b (s = 1): u, K and the vector part of x linear, orientation along
/// the geodesic.
inline void interpolate_knot(const Knot& a, const Knot& b, double s, Knot& out) {
  out.u = (1.0 - s) * a.u + s * b.u;
  out.K = (1.0 - s) * a.K + s * b.K;
  out.x = model::interpolate(a.x, b.x, s);
}

/// The knots at time `position` (in knots, 0 = first), held at both ends. Needs at least one knot.
template <class Knots>
inline void sample_knots(const Knots& knots, double position, Knot& out) {
  const double last = static_cast<double>(knots.size() - 1);
  const double p = std::clamp(position, 0.0, last);
  const std::size_t i = std::min(static_cast<std::size_t>(p), knots.size() - 1);
  const double s = p - static_cast<double>(i);
  if (s == 0.0)
    out = knots[i];
  else
    interpolate_knot(knots[i], knots[i + 1], s, out);
}

/// Tick (possibly fractional) of the last knot of an upper policy.
inline double last_tick(const UpperPolicy& policy) {
  return policy.first_tick + policy.ticks_per_knot * static_cast<double>(policy.knots.size() - 1);
}

/// Weight of an upper policy at trial tick `tick`: 0 before its first knot, 1 to its last, then a
/// straight fall to 0 over one period: a stale policy fades out and the other two layers carry on.
inline double upper_weight(const UpperPolicy& policy, double tick) {
  if (policy.knots.empty() || tick < policy.first_tick) return 0.0;
  const double age = tick - last_tick(policy);
  if (age <= 0) return 1.0;
  return std::max(0.0, 1.0 - age / policy.ticks_per_knot);
}

/// Policy at trial tick `tick`, held beyond its ends. Needs at least one knot.
inline void sample_upper(const UpperPolicy& policy, double tick, Knot& out) {
  sample_knots(policy.knots, (tick - policy.first_tick) / policy.ticks_per_knot, out);
}

/// Table at trial tick `tick`, held beyond its ends. Needs at least one knot.
inline void sample_middle(const MiddleTable& table, double tick, Knot& out) {
  sample_knots(table.knots, tick / kTicksPerMiddle, out);
}

// --- the sum -------------------------------------------------------------------------------------

/// u + K (x ⊖ x_knot). Unit rad.
inline model::Input affine(const Knot& knot, const model::State& x) {
  const model::Tangent dx = model::minus(x, knot.x);
  model::Input out;
  affine_kernel(knot.u, knot.K, dx, out);
  return out;
}

/// What each layer adds at one tick [rad]; their sum is the target before the guard.
struct LayerOutputs {
  model::Input upper = model::Input::Zero();
  model::Input middle = model::Input::Zero();
  model::Input lower = model::Input::Zero();  // primitives and reflex
  double weight = 0;                          // of the upper layer, 0..1
  model::Input sum() const { return upper + middle + lower; }
};

/// Which layers take part: values of wire::LayerMask.
struct LayerSwitches {
  bool lower = true, middle = true, upper = true, reflex = true;
  static constexpr LayerSwitches from_mask(unsigned mask) {
    return {(mask & 1u) != 0, (mask & 2u) != 0, (mask & 4u) != 0, (mask & 8u) != 0};
  }
};

/// The sum at trial tick `tick` (fractional for predictions between ticks), state x, primitive
/// target `u_primitive`.
/// `upper`, `middle` may be null or empty: that layer is silent. With the lower layer off its
/// target is replaced by `u_rest`, since targets are absolute angles and the robot has to stand
/// somewhere.
inline LayerOutputs layer_outputs(const UpperPolicy* upper, const MiddleTable* middle,
                                  const model::Input& u_primitive, const model::Input& u_rest,
                                  double tick, const model::State& x, const LayerSwitches& on,
                                  const ReflexSettings& reflex_settings, Knot& scratch) {
  LayerOutputs out;
  if (on.upper && upper != nullptr && !upper->knots.empty()) {
    out.weight = upper_weight(*upper, tick);
    if (out.weight > 0) {
      sample_upper(*upper, tick, scratch);
      out.upper = out.weight * affine(scratch, x);
    }
  }
  if (on.middle && middle != nullptr && !middle->knots.empty()) {
    sample_middle(*middle, tick, scratch);
    out.middle = affine(scratch, x);
  }
  out.lower = on.lower ? u_primitive : u_rest;
  if (on.reflex) out.lower += reflex(x, reflex_settings);
  return out;
}

}  // namespace sanso::policy
