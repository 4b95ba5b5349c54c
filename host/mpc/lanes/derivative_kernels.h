// Implementation of lane_kernels.h: perturbed states of a stage, their differences, and what is
// added analytically (residual network, slope of middle layer and reflex). Per instruction set.
#pragma once

#include "host/mpc/lanes/stage_kernels.h"

namespace sanso::mpc::SANSO_ISA {

// blocks of a tangent in world axes
inline constexpr int kLinearBlocks[2] = {model::kDPos, model::kDVel};

/// Where column c of [A | B] is evaluated (StageEvaluations).
constexpr int group_of(int c) {
  return c == 2 ? kConfigurationGroups : c < 18 ? (c - 2) / 8 : c / 8;
}
/// And in which lane.
constexpr int lane_of(int c) { return c == 2 ? 0 : c < 18 ? (c - 2) % 8 : c % 8; }
static_assert(18 == kTheta + 3 + kNu && group_of(17) == kConfigurationGroups - 1 &&
              group_of(18) == kConfigurationGroups);

/// Column of the position that a velocity's column moves; -1 for the others.
constexpr int position_of(int c) { return c >= model::kDVel && c < kNdx ? c - model::kDVel : -1; }
static_assert(position_of(model::kDOmega) == kTheta &&
              position_of(model::kDJointRate) == model::kDJoint);

/// Lays the states and inputs, each perturbed by eps along its column, into the groups' lanes. A
/// state of another velocity begins so far back that at the middle of the step, `half_step_s` on,
/// its position is the nominal one: masses and soles are those of there (kernel/step.h).
inline void spread(const double* x, const double* u_total, double eps, double half_step_s,
                   StageEvaluations& out) {
  double turn[3], middle[4];
  for (int i = 0; i < 3; ++i) turn[i] = half_step_s * x[model::kXOmega + i];
  kernel::quat_plus(x + model::kXQuat, turn, middle);
  for (int g = 0; g < kEvaluationGroups; ++g) {
    for (int i = 0; i < kNx; ++i) store(out.x[g][i], Lanes(x[i]));
    for (int i = 0; i < kNu; ++i) store(out.u[g][i], Lanes(u_total[i]));
  }
  for (int c = 2; c < kColumns; ++c) {
    auto& xs = out.x[group_of(c)];
    const int lane = lane_of(c), position = position_of(c);
    const auto turned = [&](const double* from, const double* by) {
      double quat[4];
      kernel::quat_plus(from, by, quat);
      for (int i = 0; i < 4; ++i) xs[model::kXQuat + i][lane] = quat[i];
    };
    if (c >= kNdx) {
      out.u[group_of(c)][c - kNdx][lane] += eps;
    } else if (c >= kTheta && c < kTheta + 3) {
      double d[3] = {0, 0, 0};
      d[c - kTheta] = eps;
      turned(x + model::kXQuat, d);
    } else {
      xs[c < kTheta ? c : c + 1][lane] += eps;
    }
    if (position >= kTheta && position < kTheta + 3) {
      double back[3] = {-turn[0], -turn[1], -turn[2]};
      back[position - kTheta] -= half_step_s * eps;
      turned(middle, back);
    } else if (position >= 0) {
      xs[position < kTheta ? position : position + 1][lane] -= half_step_s * eps;
    }
  }
}

typedef double UnalignedLanes __attribute__((vector_size(64), aligned(8), may_alias));

/// Eight columns of AB from `first` on: (f(x perturbed) ⊖ f(x)) / eps, with f(x) in lane `nominal`
/// of group `from`.
inline void difference_group(const StageFinish& f, int group, int from, int nominal_lane, int first,
                             StageDerivatives& out) {
  Lanes nominal[kNx], d[kNdx], xs[kNx];
  for (int i = 0; i < kNx; ++i) nominal[i] = f.evaluations->x[from][i][nominal_lane];
  load_state(f.evaluations->x[group], xs);
  for (int i = 0; i < 3; ++i) d[i] = xs[i] - nominal[i];
  quat_minus_small(xs + 3, nominal + 3, d + 3);
  for (int i = 6; i < kNdx; ++i) d[i] = xs[i + 1] - nominal[i + 1];
  const double scale = 1.0 / f.difference_step;
  for (int i = 0; i < kNdx; ++i)
    *reinterpret_cast<UnalignedLanes*>(&out.AB[i][first]) = (scale * d[i]).v;
}

/// Columns of velocities: `spread` began them farther back, and what that takes away is the
/// position's own column. Turning back by half_step_s (omega + d) from the middle is a turn of the
/// start by -J_l half_step_s d, with the left Jacobian of Exp.
inline void add_way_to_middle(const double* x, double half_step_s, StageDerivatives& out) {
  constexpr int kTurn = model::kDOmega, kRate = model::kDJointRate;
  double left[3][3];  // [column][row]
  for (int k = 0; k < 3; ++k) {
    double unit[3] = {0, 0, 0}, turn[3], once[3], twice[3];
    unit[k] = 1;
    for (int i = 0; i < 3; ++i) turn[i] = half_step_s * x[model::kXOmega + i];
    kernel::cross(turn, unit, once);
    kernel::cross(turn, once, twice);
    for (int i = 0; i < 3; ++i)
      left[k][i] = half_step_s * (unit[i] + 0.5 * once[i] + twice[i] / 6.0);
  }
  for (int i = 0; i < kNdx; ++i) {
    double* row = out.AB[i];
    for (int k = 0; k < 3; ++k) {
      row[model::kDVel + k] += half_step_s * row[k];
      row[kTurn + k] +=
          left[k][0] * row[kTheta] + left[k][1] * row[kTheta + 1] + left[k][2] * row[kTheta + 2];
    }
    for (int j = 0; j < kNu; ++j) row[kRate + j] += half_step_s * row[model::kDJoint + j];
  }
}

/// The groups overlap by two columns: what is right is written last.
inline void difference(const StageFinish& f, StageDerivatives& out) {
  constexpr int shared = kConfigurationGroups;
  difference_group(f, shared, shared, 1, 16, out);
  double height[kNdx];
  for (int i = 0; i < kNdx; ++i) height[i] = out.AB[i][16];
  for (int g = shared + 1; g < kEvaluationGroups; ++g)
    difference_group(f, g, shared, 1, 8 * g, out);
  for (int g = 0; g < shared; ++g) difference_group(f, g, 0, 0, 2 + 8 * g, out);
  for (int i = 0; i < kNdx; ++i) {
    out.AB[i][0] = out.AB[i][1] = 0;
    out.AB[i][2] = height[i];
  }
  out.AB[0][0] = out.AB[1][1] = 1;
  if (f.along_x) {
    double column[kNdx];
    state_minus(f.along_x, f.next, column);
    for (int i = 0; i < kNdx; ++i) out.AB[i][0] = column[i] / f.difference_step;
  }
  add_way_to_middle(f.x, f.half_step_s, out);
}

/// The network's input for one state and input; R turns base axes into world axes.
inline void single_features(const double* x, const double* u, const double (&R)[3][3],
                            float (&out)[kFeaturesPadded]) {
  out[0] = static_cast<float>(x[2]);
  for (int i = 0; i < 3; ++i) {
    out[1 + i] = static_cast<float>(-R[2][i]);
    out[16 + i] = static_cast<float>(R[0][i] * x[model::kXVel] + R[1][i] * x[model::kXVel + 1] +
                                     R[2][i] * x[model::kXVel + 2]);
    out[19 + i] = static_cast<float>(x[model::kXOmega + i]);
  }
  for (int j = 0; j < kNu; ++j) {
    out[4 + j] = static_cast<float>(x[model::kXJoint + j]);
    out[22 + j] = static_cast<float>(x[model::kXJointRate + j]);
    out[34 + j] = static_cast<float>(u[j]);
  }
  out[46] = out[47] = 0.0f;
}

/// Tangent in world axes of a network output in base axes.
inline void to_tangent(const float* y, const double (&R)[3][3], double* d) {
  for (int i = 0; i < kNdx; ++i) d[i] = static_cast<double>(y[i]);
  for (const int block : kLinearBlocks)
    for (int i = 0; i < 3; ++i)
      d[block + i] = R[i][0] * static_cast<double>(y[block]) +
                     R[i][1] * static_cast<double>(y[block + 1]) +
                     R[i][2] * static_cast<double>(y[block + 2]);
}

/// x <- x ⊕ d, d in the order of tangents.
inline void state_plus(double* x, const double* d) {
  double quat[4];
  kernel::quat_plus(x + model::kXQuat, d + kTheta, quat);
  for (int i = 0; i < 3; ++i) x[i] += d[i];
  for (int i = 0; i < 4; ++i) x[model::kXQuat + i] = quat[i];
  for (int i = 6; i < kNdx; ++i) x[i + 1] += d[i];
}

/// row3 += J skew(c): what J times R'c gains when the base turns, since R'c then changes by
/// skew(R'c) dtheta.
inline void add_times_skew(const float* J, const double* c, double* row3) {
  const double a = static_cast<double>(J[0]), b = static_cast<double>(J[1]),
               d = static_cast<double>(J[2]);
  row3[0] += b * c[2] - d * c[1];
  row3[1] += d * c[0] - a * c[2];
  row3[2] += a * c[1] - b * c[0];
}

/// Derivative of the network's tangent with respect to tangent and input, added to AB; `d` is the
/// tangent itself.
inline void add_residual_derivative(const double (&R)[3][3],
                                    const float (&features)[kFeaturesPadded],
                                    const float (&y)[kOutputsPadded],
                                    const float (&J)[kOutputCount][kFeaturesPadded],
                                    const double* d, StageDerivatives& out) {
  // analytical orientation columns as seen from the corrected orientation: Exp(d)' A = A - d x A +
  // ..
  const double* t = d + kTheta;
  for (int c = 0; c < kColumns; ++c) {
    double a[3] = {out.AB[3][c], out.AB[4][c], out.AB[5][c]}, once[3], twice[3];
    kernel::cross(t, a, once);
    kernel::cross(t, once, twice);
    for (int i = 0; i < 3; ++i) out.AB[3 + i][c] = a[i] - once[i] + 0.5 * twice[i];
  }
  double g[3], v[3];
  for (int i = 0; i < 3; ++i)
    g[i] = static_cast<double>(features[1 + i]), v[i] = static_cast<double>(features[16 + i]);
  alignas(64) double D[kNdx][kColumns];
  for (int i = 0; i < kNdx; ++i) {
    const float* row = J[i];
    D[i][0] = D[i][1] = D[i][3] = D[i][4] = D[i][5] = 0;
    D[i][2] = static_cast<double>(row[0]);
    add_times_skew(row + 1, g, &D[i][kTheta]);
    add_times_skew(row + 16, v, &D[i][kTheta]);
    for (int j = 0; j < 3; ++j) {
      D[i][model::kDVel + j] = static_cast<double>(row[16]) * R[j][0] +
                               static_cast<double>(row[17]) * R[j][1] +
                               static_cast<double>(row[18]) * R[j][2];
      D[i][model::kDOmega + j] = static_cast<double>(row[19 + j]);
    }
    for (int j = 0; j < kNu; ++j) {
      D[i][model::kDJoint + j] = static_cast<double>(row[4 + j]);
      D[i][model::kDJointRate + j] = static_cast<double>(row[22 + j]);
      D[i][kNdx + j] = static_cast<double>(row[34 + j]);
    }
  }
  // orientation: the network's own change enters through the right Jacobian of Exp, 1 - skew(d)/2 +
  // ..
  for (int c = 0; c < kColumns; ++c) {
    double a[3] = {D[3][c], D[4][c], D[5][c]}, once[3], twice[3];
    kernel::cross(t, a, once);
    kernel::cross(t, once, twice);
    for (int i = 0; i < 3; ++i) D[3 + i][c] = a[i] - 0.5 * once[i] + twice[i] / 6.0;
  }
  for (const int block : kLinearBlocks) {
    // linear blocks: R y, and turning the base turns them: -R skew(y)
    for (int i = 0; i < 3; ++i) {
      const float unit[3] = {i == 0 ? 1.0f : 0.0f, i == 1 ? 1.0f : 0.0f, i == 2 ? 1.0f : 0.0f};
      const double yb[3] = {-static_cast<double>(y[block]), -static_cast<double>(y[block + 1]),
                            -static_cast<double>(y[block + 2])};
      add_times_skew(unit, yb, &D[block + i][kTheta]);
    }
    for (int c = 0; c < kColumns; ++c)
      for (int i = 0; i < 3; ++i)
        out.AB[block + i][c] +=
            R[i][0] * D[block][c] + R[i][1] * D[block + 1][c] + R[i][2] * D[block + 2][c];
  }
  for (int i = 3; i < kNdx; ++i)
    if (i < model::kDVel || i >= model::kDVel + 3)
      for (int c = 0; c < kColumns; ++c) out.AB[i][c] += D[i][c];
}

/// A += B (d layers / dx).
inline void add_layer_slope(const double (*slope)[kNdxPadded], StageDerivatives& out) {
  for (int i = 0; i < kNdx; i += 4) {
    alignas(64) double rows[4][kNdxPadded];
    multiply<4, kNdxPadded, Start::at_zero>(&out.AB[i][kNdx], kColumns, 1, slope[0], kNdxPadded,
                                            kNu, rows[0], kNdxPadded);
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < kNdx; ++c) out.AB[i + r][c] += rows[r][c];
  }
}

/// [A | B] and F of a stage from its evaluations: differences, network, the layers' slope.
inline void finish_stage(const StageFinish& f, StageDerivatives& out) {
  double next[kNx], without[kNx], R[3][3];
  for (int i = 0; i < kNx; ++i) next[i] = f.next[i], without[i] = f.without_upper[i];
  difference(f, out);
  if (f.residual) {
    alignas(64) float features[kFeaturesPadded], y[kOutputsPadded];
    double d[kNdx];
    kernel::rotation_from_quat(f.x + model::kXQuat, R);
    single_features(f.x, f.u_total, R, features);
    residual_jacobian(*f.residual, features, y, *f.jacobian);
    to_tangent(y, R, d);
    add_residual_derivative(R, features, y, f.jacobian->J, d, out);
    state_plus(next, d);
    single_features(f.x, f.u_without_upper, R, features);
    residual_single(*f.residual, features, y);
    to_tangent(y, R, d);
    state_plus(without, d);
  }
  state_minus(next, without, out.F);
  add_layer_slope(f.layer_slope, out);
}

}  // namespace sanso::mpc::SANSO_ISA
