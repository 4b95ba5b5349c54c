// Contact of the eight sole corners on velocity level, solved in the six-dimensional twist space of
// each foot.
// Per corner, with v+ the velocity at the end of the step and lambda the impulse over the step [N
// s]:
//   normal    lambda_n >= 0,  u_n + gap/h >= 0,  complementary (gap scaled by `recovery` inside the
//   ground)
//   tangents  |lambda_x| <= mu_forward lambda_n,  |lambda_y| <= mu_sideways lambda_n, opposing u_x,
//   u_y
// The gap stands inside the constraint, so that contacts to come are seen and differences stay
// finite.
#pragma once

#include "shared/model/foot_shape.h"
#include "shared/model/kernel/block_solve.h"
#include "shared/model/kernel/ground_lanes.h"

namespace sanso::model::SANSO_ISA {

/// Corner order: front outer, back outer, back inner, front inner; signs of the half length and
/// half width (left foot).
inline constexpr double kCornerX[kCornersPerFoot] = {1, -1, -1, 1};
inline constexpr double kCornerY[kCornersPerFoot] = {1, 1, -1, -1};

/// Rows of a foot: three a corner, 3 k + 0 forward, + 1 across, + 2 normal.
inline constexpr int kFootRows = 3 * kCornersPerFoot;

/// Contact frame of a foot: origin in the sole's centre, axes 0 along the foot (in the surface), 1
/// across, 2 normal.
template <class T>
struct FootContact {
  T axis[3][3];                   // [axis][component]: contact axes in base axes
  T p_base_sole[3];               // m
  T corner[kCornersPerFoot][3];   // m, corners from the sole's centre, contact axes
  T gap[kCornersPerFoot];         // m, distance of the corner along the normal, negative inside
  T bend[kCornersPerFoot];        // m, of wheels: how far the ground falls off on their way
  T bend_ahead[kCornersPerFoot];  // and its change per metre that they roll further
  T cos_slope;                    // of the ground below
  T X[6][6];                      // [joint][twist]: transposed Jacobian of the leg, then L^-1 of it
  // [base][twist]: transposed Jacobian of the base, then reduced by the leg
  T G[6][6];
  T twist[6];    // m/s, rad/s: velocity of the sole's centre, contact axes
  T impulse[6];  // N s, N m s: sum over the corners
  // velocity of a row per unit of its impulse, softness included
  T diagonal[kFootRows], inverse_diagonal[kFootRows];
  // [row pushed][row that answers]: velocities per unit impulse; only the sweeps need it
  T response[kFootRows][kFootRows];
  // m/s: velocity of the row + its target + softness x impulse; zero where a row holds
  T residual[kFootRows];
};

/// Contact frame, corners and gaps. R_world_base[row][column]. Wheels roll on by `ahead` [m along
/// world x] from the middle of this step to that of the next: their normal is that of the middle of
/// this way, and where the ground is at its end counts too. On a plane that changes nothing.
template <class T>
inline void foot_geometry(const FootShape& shape, const Ground& ground, const T* p_world_base,
                          const T (&R_world_base)[3][3], const LegFrames<T>& frames, double side,
                          T ahead, FootContact<T>& foot) {
  const auto& R = frames.R_base_foot;
  T half_x[3], half_y[3];
  for (int i = 0; i < 3; ++i) {
    foot.p_base_sole[i] = frames.origin[5][i] + kSoleCentreX * R[0][i] +
                          (side * kSoleCentreY) * R[1][i] + shape.height * R[2][i];
    half_x[i] = shape.half_length * R[0][i];
    half_y[i] = (side * shape.half_width) * R[1][i];
  }
  const auto& W = R_world_base;
  const T x_sole = p_world_base[0] + dot(W[0], foot.p_base_sole),
          z_sole = p_world_base[2] + dot(W[2], foot.p_base_sole);
  const GroundPoint<T> below = ground_at(ground, shape.wheels ? x_sole + 0.5 * ahead : x_sole);
  foot.cos_slope = below.cos_slope;
  // normal in world axes is (-sin, 0, cos); into base axes
  T* n = foot.axis[2];
  for (int i = 0; i < 3; ++i) n[i] = below.cos_slope * W[2][i] - below.sin_slope * W[0][i];
  // across the foot: n x (foot x); a foot that stands on its toe has no forward direction: then n x
  // (foot z)
  T* across = foot.axis[1];
  T by_z[3];
  cross(n, R[0], across);
  cross(n, R[2], by_z);
  const T length2 = dot(across, across);
  for (int i = 0; i < 3; ++i) across[i] = select_less(length2, T(1e-4), by_z[i], across[i]);
  const T scale = 1.0 / sqrt_of(max_of(dot(across, across), T(1e-12)));
  for (int i = 0; i < 3; ++i) across[i] = across[i] * scale;
  cross(across, n, foot.axis[0]);

  T lx[3], ly[3];  // half sides in contact axes
  for (int i = 0; i < 3; ++i) {
    lx[i] = dot(foot.axis[i], half_x);
    ly[i] = dot(foot.axis[i], half_y);
  }
  const T x_along = dot(W[0], half_x), x_across = dot(W[0], half_y);
  const T z_along = dot(W[2], half_x), z_across = dot(W[2], half_y);
  for (int k = 0; k < kCornersPerFoot; ++k) {
    for (int i = 0; i < 3; ++i) foot.corner[k][i] = kCornerX[k] * lx[i] + kCornerY[k] * ly[i];
    const T x = x_sole + kCornerX[k] * x_along + kCornerY[k] * x_across;
    const T z = z_sole + kCornerX[k] * z_along + kCornerY[k] * z_across;
    foot.gap[k] = (z - ground_at(ground, x).z) * below.cos_slope;
    if (!shape.wheels) continue;
    const T here = ground_at(ground, x).z;
    const GroundPoint<T> there = ground_at(ground, x + ahead);
    foot.bend[k] = (here - there.z) * below.cos_slope + ahead * below.sin_slope;
    foot.bend_ahead[k] = below.sin_slope - below.cos_slope * there.sin_slope / there.cos_slope;
  }
}

/// Transposed Jacobian of the sole's centre in contact axes, and the present twist.
template <class T>
inline void foot_jacobian(const LegFrames<T>& frames, const T* rate, const T* v_base_in_base,
                          const T* w_base, FootContact<T>& foot) {
  const T* p = foot.p_base_sole;
  for (int i = 0; i < 3; ++i) {
    T p_cross_axis[3];
    cross(p, foot.axis[i], p_cross_axis);
    for (int c = 0; c < 3; ++c) {
      foot.G[c][i] = foot.axis[i][c];
      foot.G[c][3 + i] = T(0.0);
      foot.G[3 + c][i] = p_cross_axis[c];
      foot.G[3 + c][3 + i] = foot.axis[i][c];
    }
    foot.twist[i] = dot(foot.axis[i], v_base_in_base) + dot(p_cross_axis, w_base);
    foot.twist[3 + i] = dot(foot.axis[i], w_base);
  }
  for (int j = 0; j < kLegJoints; ++j) {
    T arm[3], lever[3];
    for (int i = 0; i < 3; ++i) arm[i] = p[i] - frames.origin[j][i];
    cross(frames.axis[j], arm, lever);
    for (int i = 0; i < 3; ++i) {
      foot.X[j][i] = dot(foot.axis[i], lever);
      foot.X[j][3 + i] = dot(foot.axis[i], frames.axis[j]);
      foot.twist[i] += foot.X[j][i] * rate[j];
      foot.twist[3 + i] += foot.X[j][3 + i] * rate[j];
    }
  }
}

/// Wrench of a force at r: force and r x force.
template <class T>
inline void add_wrench(const T* r, const T* f, T* wrench) {
  wrench[0] += f[0];
  wrench[1] += f[1];
  wrench[2] += f[2];
  wrench[3] += r[1] * f[2] - r[2] * f[1];
  wrench[4] += r[2] * f[0] - r[0] * f[2];
  wrench[5] += r[0] * f[1] - r[1] * f[0];
}

/// Velocities of a corner at r for a twist of the sole's centre: forward, across, normal.
template <class T>
inline void corner_velocity(const T* t, const T* r, T* u) {
  u[0] = t[0] + t[4] * r[2] - t[5] * r[1];
  u[1] = t[1] + t[5] * r[0] - t[3] * r[2];
  u[2] = t[2] + t[3] * r[1] - t[4] * r[0];
}

/// Twist of the sole for a unit impulse along contact axis Axis at a corner r, from the foot's 6 x
/// 6 inverse inertia A.
template <int Axis, class T>
inline T corner_push(const T (&A)[6][6], const T* r, int i) {
  constexpr int I = (Axis + 1) % 3, J = (Axis + 2) % 3;
  return A[i][Axis] + r[J] * A[i][3 + I] - r[I] * A[i][3 + J];
}

/// What every row of a foot answers to its own impulse.
template <int Axis, class T>
inline T row_diagonal(const T (&A)[6][6], const T* r) {
  constexpr int I = (Axis + 1) % 3, J = (Axis + 2) % 3;
  return corner_push<Axis>(A, r, Axis) + corner_push<Axis>(A, r, 3 + I) * r[J] -
         corner_push<Axis>(A, r, 3 + J) * r[I];
}
template <class T>
inline void row_diagonals(const T (&A)[6][6], double regularization, FootContact<T>& foot) {
  for (int k = 0; k < kCornersPerFoot; ++k) {
    const T* r = foot.corner[k];
    T* diagonal = foot.diagonal + 3 * k;
    diagonal[0] = (1.0 + regularization) * row_diagonal<0>(A, r);
    diagonal[1] = (1.0 + regularization) * row_diagonal<1>(A, r);
    diagonal[2] = (1.0 + regularization) * row_diagonal<2>(A, r);
    for (int a = 0; a < 3; ++a) foot.inverse_diagonal[3 * k + a] = 1.0 / diagonal[a];
  }
}

/// Responses of all rows of a foot to each other, after row_diagonals.
template <class T>
inline void row_responses(const T (&A)[6][6], FootContact<T>& foot) {
#pragma GCC unroll 1
  for (int k = 0; k < kCornersPerFoot; ++k) {
    T twist[3][6];  // of the sole for a unit impulse forward, across, normal at corner k
    for (int i = 0; i < 6; ++i) {
      twist[0][i] = corner_push<0>(A, foot.corner[k], i);
      twist[1][i] = corner_push<1>(A, foot.corner[k], i);
      twist[2][i] = corner_push<2>(A, foot.corner[k], i);
    }
    for (int a = 0; a < 3; ++a) {
      T* row = foot.response[3 * k + a];
      for (int other = 0; other < kCornersPerFoot; ++other)
        corner_velocity(twist[a], foot.corner[other], row + 3 * other);
      row[3 * k + a] = foot.diagonal[3 * k + a];
    }
  }
}

/// Adds the velocities that a change of the foot's twist brings to the residuals of its rows.
template <class T>
inline void add_twist(const T* twist, FootContact<T>& foot) {
  for (int k = 0; k < kCornersPerFoot; ++k) {
    T u[3];
    corner_velocity(twist, foot.corner[k], u);
    for (int a = 0; a < 3; ++a) foot.residual[3 * k + a] += u[a];
  }
}

/// One Gauss-Seidel pass over the corners of a foot: normal row, then both tangents at once (they
/// hardly see each other).
/// The change of the foot's impulse is added to `change`.
template <class T>
inline void sweep_foot(double mu_forward, double mu_sideways, FootContact<T>& foot, T* lambda,
                       T* change) {
  T s[kFootRows];  // a local copy stays in registers: nothing else can point to it
  for (int i = 0; i < kFootRows; ++i) s[i] = foot.residual[i];
#pragma GCC unroll 4
  for (int k = 0; k < kCornersPerFoot; ++k) {
    T step[3];
    const int x = 3 * k, y = x + 1, n = x + 2;
    const T was[3] = {lambda[x], lambda[y], lambda[n]};
    const T normal = max_of(was[2] - s[n] * foot.inverse_diagonal[n], T(0.0));
    step[2] = normal - was[2];
#pragma GCC unroll 12
    for (int i = 0; i < kFootRows; ++i) s[i] += foot.response[n][i] * step[2];
    const T limit_x = mu_forward * normal, limit_y = mu_sideways * normal;
    const T forward = min_of(max_of(was[0] - s[x] * foot.inverse_diagonal[x], -limit_x), limit_x);
    const T across = min_of(max_of(was[1] - s[y] * foot.inverse_diagonal[y], -limit_y), limit_y);
    step[0] = forward - was[0];
    step[1] = across - was[1];
#pragma GCC unroll 12
    for (int i = 0; i < kFootRows; ++i) s[i] += foot.response[x][i] * step[0];
#pragma GCC unroll 12
    for (int i = 0; i < kFootRows; ++i) s[i] += foot.response[y][i] * step[1];
    lambda[x] = forward;
    lambda[y] = across;
    lambda[n] = normal;
    add_wrench(foot.corner[k], step, change);
  }
  for (int i = 0; i < kFootRows; ++i) foot.residual[i] = s[i];
}

}  // namespace sanso::model::SANSO_ISA
