// Implementation of lane_kernels.h: inputs of the layers, cost and residual of a group of lanes.
// Per instruction set.
#pragma once

#include "host/mpc/lane_kernels.h"
#include "host/mpc/lanes/math_lanes.h"
#include "host/mpc/lanes/residual_lanes.h"
#include "shared/model/kernel/exponential.h"
#include "shared/policy/layer_kernels.h"

namespace sanso::mpc::SANSO_ISA {

template <int W>
inline kernel::Pack<W> load_row(const double (&p)[W]) {
  return kernel::Pack<W>(*reinterpret_cast<const typename kernel::Pack<W>::Lanes*>(p));
}
inline Quad load_quad(const double* p) { return Quad(*reinterpret_cast<const Quad::Lanes*>(p)); }
template <int W>
inline void store(double* p, kernel::Pack<W> a) {
  *reinterpret_cast<typename kernel::Pack<W>::Lanes*>(p) = a.v;
}

template <int W>
inline void load_state(const double (*x)[W], kernel::Pack<W>* out) {
  for (int i = 0; i < kNx; ++i) out[i] = load_row(x[i]);
}

/// x ⊖ y with one y for all lanes.
inline void minus_shared(const LaneArray* x, const double* y, Quad* out) {
  Quad xs[kNx], ys[kNx];
  load_state(x, xs);
  for (int i = 0; i < kNx; ++i) ys[i] = y[i];
  state_minus(xs, ys, out);
}

/// u_upper of every lane: the nominal one, a step along k of the lane's own length, feedback K on
/// its state, within the limit [rad]. Adds the price of noise to `noise_cost`.
inline void line_inputs(const LineStage& s, const LaneArray* x, LaneArray* u_upper,
                        double* noise_cost) {
  Quad u[kNu], change[kNu];
  for (int i = 0; i < kNu; ++i) u[i] = s.u_nominal[i];
  if (s.gains) {
    Quad dx[kNdx];
    minus_shared(x, s.x_nominal, dx);
    const Quad steps = load_quad(s.steps);
    const auto gain = [&](int i, int j) { return Quad(s.gains->K[i][j]); };
    for (int i = 0; i < kNu; ++i) u[i] = u[i] + s.gains->k[i] * steps;
    policy::affine_kernel(u, gain, dx, u);
  }
  for (int i = 0; i < kNu; ++i) {
    u[i] = kernel::min_of(kernel::max_of(u[i], Quad(-s.input_limit_rad)), Quad(s.input_limit_rad));
    change[i] = u[i] - s.u_nominal[i];
    store(u_upper[i], u[i]);
  }
  if (!s.noise) return;
  Quad price = s.noise->still;
  for (int i = 0; i < kNu; ++i) {
    Quad row = 2.0 * s.noise->slope[i];
    for (int j = 0; j < kNu; ++j) row += s.noise->curvature[i][j] * change[j];
    price += change[i] * row;
  }
  store(noise_cost, load_quad(noise_cost) + 0.5 * price);
}

/// u of every lane: the upper layer's, what is fixed at this knot, the middle layer's feedback and
/// the reflexes.
inline void layer_inputs(const StageContext& c, const ReflexContext& reflex, const LaneArray* x,
                         const LaneArray* u_upper, LaneArray* u) {
  Quad sum[kNu];
  for (int i = 0; i < kNu; ++i) sum[i] = load_row(u_upper[i]) + Quad(c.u_fixed[i]);
  if (c.has_middle) {
    Quad dx[kNdx];
    minus_shared(x, c.x_middle, dx);
    const auto gain = [&](int i, int j) { return Quad(c.K_middle[i][j]); };
    policy::affine_kernel(sum, gain, dx, sum);
  }
  if (reflex.on) {
    for (int i = 0; i < kNu; ++i) {
      const Quad q = load_row(x[model::kXJoint + i]);
      sum[i] +=
          policy::reflex_complement_kernel(q, reflex.lower[i], reflex.upper[i], reflex.settings,
                                           [](Quad v) { return kernel::exp_inside(v); });
    }
  }
  for (int i = 0; i < kNu; ++i) store(u[i], sum[i]);
}

/// Features of a group of lanes, transposed into rows of single precision.
inline void lane_features(const Quad* x, const LaneArray* u,
                          float (&out)[kRollOutLanes][kFeaturesPadded]) {
  Quad R[3][3], f[kFeatureCount];
  kernel::rotation_from_quat(x + model::kXQuat, R);
  f[0] = x[2];
  for (int i = 0; i < 3; ++i) {
    f[1 + i] = -R[2][i];
    f[16 + i] =
        R[0][i] * x[model::kXVel] + R[1][i] * x[model::kXVel + 1] + R[2][i] * x[model::kXVel + 2];
    f[19 + i] = x[model::kXOmega + i];
  }
  for (int j = 0; j < kNu; ++j) {
    f[4 + j] = x[model::kXJoint + j];
    f[22 + j] = x[model::kXJointRate + j];
    f[34 + j] = load_row(u[j]);
  }
  for (int i = 0; i < kFeatureCount; ++i)
    for (int lane = 0; lane < kRollOutLanes; ++lane)
      out[lane][i] = static_cast<float>(f[i].v[lane]);
  for (auto& row : out) row[46] = row[47] = 0.0f;
}

/// Adds the network's correction, times `share`, to the next state of every lane.
inline void add_residual(const ResidualWeights& weights, double share, const LaneArray* x,
                         const LaneArray* u, LaneArray* x_next) {
  alignas(64) float features[kRollOutLanes][kFeaturesPadded], output[kRollOutLanes][kOutputsPadded];
  Quad xs[kNx], y[kNdx], R[3][3], next[kNx];
  load_state(x, xs);
  lane_features(xs, u, features);
  residual_lanes(weights, features, output);
  for (int i = 0; i < kNdx; ++i)
    for (int lane = 0; lane < kRollOutLanes; ++lane)
      y[i].v[lane] = share * static_cast<double>(output[lane][i]);
  kernel::rotation_from_quat(xs + model::kXQuat, R);
  load_state(x_next, next);
  for (int i = 0; i < 3; ++i) {
    next[i] += R[i][0] * y[0] + R[i][1] * y[1] + R[i][2] * y[2];
    next[model::kXVel + i] += R[i][0] * y[18] + R[i][1] * y[19] + R[i][2] * y[20];
    next[model::kXOmega + i] += y[model::kDOmega + i];
  }
  kernel::quat_plus(next + model::kXQuat, y + kTheta, next + model::kXQuat);
  for (int j = 0; j < kNu; ++j) {
    next[model::kXJoint + j] += y[model::kDJoint + j];
    next[model::kXJointRate + j] += y[model::kDJointRate + j];
  }
  for (int i = 0; i < kNx; ++i) store(x_next[i], next[i]);
}

/// Adds the cost of a knot; without `u_upper` that of the state alone.
inline void add_cost(const ProblemContext& p, int knot, const LaneArray* x,
                     const LaneArray* u_upper, double* cost) {
  Quad e[kNdx], sum = load_quad(cost);
  minus_shared(x, p.x_ref[knot], e);
  for (int i = 0; i < kNdx; ++i) sum += p.state_weight[i] * (e[i] * e[i]);
  if (u_upper)
    for (int i = 0; i < kNu; ++i) {
      const Quad u = load_row(u_upper[i]);
      sum += p.input_weight[i] * (u * u);
    }
  store(cost, sum);
}

}  // namespace sanso::mpc::SANSO_ISA
