// The low-level sum of the layers: u = u_up + K_up (x ⊖ x_up) + u_mid + K_mid (x ⊖ x_mid) + u_low,
// with first-order hold between knots. One implementation: the controller executes it every 10 ms,
// the host predicts with it, and without its upper terms it is what the noise term F needs. No
// heap.
#pragma once

#include <algorithm>
#include <cmath>

#include "shared/model/joints.h"
#include "shared/policy/layer_kernels.h"
#include "shared/policy/policy_types.h"

namespace sanso::policy {

// --- the reflex ----------------------------------------------------------------------------------

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
  /// The target, rad, not yet limited by the guard.
  model::Input sum() const { return upper + middle + lower; }
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
