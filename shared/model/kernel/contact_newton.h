// Finishes the contact solution that Gauss-Seidel began: with the set of touching, sticking and
// sliding rows it has found, the remaining equations are linear and solved exactly (a semi-smooth
// Newton step). Gauss-Seidel alone leaves 10 to 20 % of some derivatives behind after 24 sweeps;
// where the set was right, one such step leaves rounding only. Where it was not, the step shows by
// its defect that another round is needed.
//
// Unknown is the change tau of both soles' twists (12). A row r that is free has residual zero:
//   s_r + J_r tau + S_r y_r = 0,   A^-1 tau = w0 + sum_r d_r y_r
//   =>  (A^-1 + sum_r d_r J_r' / S_r) tau = w0 - sum_r d_r s_r / S_r
// with S_r the softness, y_r the change of its impulse, d_r the wrench of a unit of it (a normal
// row carries its sliding tangents along), and w0 the wrench of setting the other rows to their
// bounds.
#pragma once

#include "shared/model/kernel/contact.h"

namespace sanso::model::SANSO_ISA {

inline constexpr int kTwists = 6 * kNumFeet;

/// M <- -M^-1 for a symmetric positive definite M: the sweep operator over all diagonal entries,
/// lower triangle only.
template <class T>
inline void negative_inverse(T (&M)[kTwists][kTwists]) {
#pragma GCC unroll 1
  for (int k = 0; k < kTwists; ++k) {
    T column[kTwists];
    for (int i = 0; i < kTwists; ++i) column[i] = i > k ? M[i][k] : M[k][i];
    const T pivot = 1.0 / column[k];
    // row and column k too, without a branch: they are written afterwards
#pragma GCC unroll 12
    for (int i = 0; i < kTwists; ++i) {
      const T scaled = column[i] * pivot;
#pragma GCC unroll 12
      for (int j = 0; j <= i; ++j) M[i][j] -= scaled * column[j];
    }
    for (int i = 0; i < kTwists; ++i) (i > k ? M[i][k] : M[k][i]) = column[i] * pivot;
    M[k][k] = -pivot;
  }
}

/// L U of M in place by elimination without exchanges (M is positive definite but for the part of
/// sliding friction): U above the diagonal, inverse pivots on it, multipliers below. Row by row, so
/// that a row stays in registers.
template <class T>
inline void factorize12(T (&M)[kTwists][kTwists]) {
#pragma GCC unroll 12
  for (int i = 0; i < kTwists; ++i) {
    T row[kTwists];
#pragma GCC unroll 12
    for (int j = 0; j < kTwists; ++j) row[j] = M[i][j];
#pragma GCC unroll 12
    for (int k = 0; k < i; ++k) {
      row[k] = row[k] * M[k][k];
#pragma GCC unroll 12
      for (int j = k + 1; j < kTwists; ++j) row[j] -= row[k] * M[k][j];
    }
    row[i] = 1.0 / row[i];
#pragma GCC unroll 12
    for (int j = 0; j < kTwists; ++j) M[i][j] = row[j];
  }
}

/// b <- M^-1 b with M from factorize12.
template <class S, class T>
inline void solve12(const S (&M)[kTwists][kTwists], T (&b)[kTwists]) {
#pragma GCC unroll 12
  for (int k = 0; k < kTwists; ++k)
#pragma GCC unroll 12
    for (int i = k + 1; i < kTwists; ++i) b[i] -= M[i][k] * b[k];
#pragma GCC unroll 12
  for (int j = kTwists - 1; j >= 0; --j) {
    b[j] = b[j] * M[j][j];
#pragma GCC unroll 12
    for (int i = 0; i < j; ++i) b[i] -= M[i][j] * b[j];
  }
}

/// Which rows of a corner are free, and where the others go.
template <class T>
struct CornerSet {
  T weight[3];  // 1 / S of a free row, else 0
  T slide[2];   // a sliding tangent follows its normal: lambda_t = slide lambda_n; else 0
  T jump[3];    // change of impulse that sets the rows that are not free to their bounds
};

/// Of corner k of a foot with impulses `lambda` [N s], three a corner: touching where the normal
/// would push, sticking inside the friction cone mu_forward x mu_sideways. Axes of the foot.
template <class T>
inline void corner_set(double mu_forward, double mu_sideways, double softness,
                       const FootContact<T>& foot, int k, const T* lambda, CornerSet<T>& set) {
  const double mu[2] = {mu_forward, mu_sideways};
  const int n = 3 * k + 2;
  const T wanted = lambda[n] - foot.residual[n] * foot.inverse_diagonal[n];
  const T touching = select_less(T(0.0), wanted, T(1.0), T(0.0));
  const T normal = touching * lambda[n];
  set.weight[2] = touching * foot.inverse_diagonal[n] * (1.0 / softness);
  set.jump[2] = normal - lambda[n];
  for (int a = 0; a < 2; ++a) {
    const int t = 3 * k + a;
    const T goal = lambda[t] - foot.residual[t] * foot.inverse_diagonal[t];
    const T limit = mu[a] * max_of(wanted, T(0.0));
    const T sticking = touching * select_less(abs_of(goal), limit, T(1.0), T(0.0));
    const T sign = select_less(goal, T(0.0), T(-1.0), T(1.0));
    set.weight[a] = sticking * foot.inverse_diagonal[t] * (1.0 / softness);
    set.slide[a] = (touching - sticking) * (mu[a] * sign);
    set.jump[a] = select_less(T(0.5), sticking, T(0.0), set.slide[a] * normal - lambda[t]);
  }
}

/// How far the impulses are from being their own projection, over all rows of a foot: zero at the
/// solution.
template <class T>
inline T contact_defect(double mu_forward, double mu_sideways, const FootContact<T>& foot,
                        const T* lambda) {
  T sum = 0.0;
  for (int k = 0; k < kCornersPerFoot; ++k) {
    const int x = 3 * k, y = x + 1, n = x + 2;
    const T normal =
        max_of(lambda[n] - foot.residual[n] * foot.inverse_diagonal[n], T(0.0)) - lambda[n];
    const T limit_x = mu_forward * lambda[n], limit_y = mu_sideways * lambda[n];
    const T forward =
        min_of(max_of(lambda[x] - foot.residual[x] * foot.inverse_diagonal[x], -limit_x), limit_x) -
        lambda[x];
    const T across =
        min_of(max_of(lambda[y] - foot.residual[y] * foot.inverse_diagonal[y], -limit_y), limit_y) -
        lambda[y];
    sum += normal * normal + forward * forward + across * across;
  }
  return sum;
}

/// Adds the free rows of a corner to the matrix block and the right-hand side of its foot (rows
/// `at` .. at + 5).
template <class T>
inline void add_corner(const FootContact<T>& foot, int k, const CornerSet<T>& set, int at,
                       T (&M)[kTwists][kTwists], T (&rhs)[kTwists]) {
  const T* r = foot.corner[k];
  const T* s = foot.residual + 3 * k;
  // rows of J: velocity of the corner per twist; wrench of a unit impulse is its transpose
  const T zero = 0.0, one = 1.0;
  const T J[3][6] = {{one, zero, zero, zero, r[2], -r[1]},
                     {zero, one, zero, -r[2], zero, r[0]},
                     {zero, zero, one, r[1], -r[0], zero}};
  constexpr int entries[3][3] = {{0, 4, 5}, {1, 3, 5}, {2, 3, 4}};
  T force[3] = {set.slide[0], set.slide[1], one}, d[6] = {}, jump[6] = {};
  add_wrench(r, force, d);
  add_wrench(r, set.jump, jump);
  for (int i = 0; i < 6; ++i) {
    rhs[at + i] += jump[i] - d[i] * (set.weight[2] * s[2]);
    for (const int c : entries[2]) M[at + i][at + c] += d[i] * (set.weight[2] * J[2][c]);
  }
  for (int a = 0; a < 2; ++a)
    for (const int i : entries[a]) {
      rhs[at + i] -= J[a][i] * (set.weight[a] * s[a]);
      for (const int c : entries[a]) M[at + i][at + c] += J[a][i] * (set.weight[a] * J[a][c]);
    }
}

/// New impulses of a corner after the twist of its foot changed by tau, clamped into the pyramid.
/// `change` receives the difference to the old ones.
template <class T>
inline void corner_impulses(double mu_forward, double mu_sideways, const FootContact<T>& foot,
                            int k, const CornerSet<T>& set, const T* tau, const T* lambda,
                            T* change) {
  T u[3], next[3];
  corner_velocity(tau, foot.corner[k], u);
  const T* old = lambda + 3 * k;
  for (int a = 0; a < 3; ++a)
    next[a] = old[a] + set.jump[a] - set.weight[a] * (foot.residual[3 * k + a] + u[a]);
  next[2] = max_of(next[2], T(0.0));
  const double mu[2] = {mu_forward, mu_sideways};
  for (int a = 0; a < 2; ++a) {
    const T sliding = abs_of(set.slide[a]);
    next[a] = select_less(T(0.0), sliding, set.slide[a] * next[2], next[a]);
    next[a] = min_of(max_of(next[a], -mu[a] * next[2]), mu[a] * next[2]);
  }
  for (int a = 0; a < 3; ++a) change[a] = next[a] - old[a];
}

/// The inverse inertia of both soles together, negated: once per step, for all Newton steps.
template <class T>
inline void sole_inertia(const T (&A)[kNumFeet][6][6], const T (&A_cross)[6][6],
                         T (&negative_inertia)[kTwists][kTwists]) {
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      negative_inertia[i][j] = A[0][i][j];
      negative_inertia[6 + i][6 + j] = A[1][i][j];
      negative_inertia[6 + i][j] = A_cross[j][i];  // A_cross: right rows, left columns
      negative_inertia[i][6 + j] = A_cross[i][j];
    }
  // a straight leg makes a direction of the sole nearly immovable: keeps the inverse finite there
  for (int i = 0; i < kTwists; ++i)
    negative_inertia[i][i] = (1.0 + 1e-11) * negative_inertia[i][i] + 1e-12;
  negative_inverse(negative_inertia);
}

/// One Newton step over all rows of both feet. A lane keeps its old impulses where the step did not
/// come closer.
/// Returns the contact defect of what each lane ends with [(N s)^2].
template <class T>
inline T newton_step(double mu_forward, double mu_sideways, double regularization,
                     const T (&A)[kNumFeet][6][6], const T (&A_cross)[6][6],
                     const T (&negative_inertia)[kTwists][kTwists],
                     FootContact<T> (&foot)[kNumFeet], T (*lambda)[kCornersPerFoot][3]) {
  const double softness = regularization / (1.0 + regularization);
  T M[kTwists][kTwists], tau[kTwists] = {};
#pragma GCC unroll 12
  for (int i = 0; i < kTwists; ++i)
#pragma GCC unroll 12
    for (int j = 0; j <= i; ++j) M[i][j] = M[j][i] = -negative_inertia[i][j];
  CornerSet<T> set[kNumFeet][kCornersPerFoot];
  T* impulse[kNumFeet] = {lambda[0][0], lambda[1][0]};  // rows of a foot, flat
  T before = 0.0;
  for (int l = 0; l < kNumFeet; ++l) {
    before += contact_defect(mu_forward, mu_sideways, foot[l], impulse[l]);
    for (int k = 0; k < kCornersPerFoot; ++k) {
      corner_set(mu_forward, mu_sideways, softness, foot[l], k, impulse[l], set[l][k]);
      add_corner(foot[l], k, set[l][k], 6 * l, M, tau);
    }
  }
  factorize12(M);
  solve12(M, tau);

  T change[kNumFeet][kFootRows], wrench[kNumFeet][6] = {}, twist[kNumFeet][6] = {};
  for (int l = 0; l < kNumFeet; ++l)
    for (int k = 0; k < kCornersPerFoot; ++k) {
      corner_impulses(mu_forward, mu_sideways, foot[l], k, set[l][k], tau + 6 * l, impulse[l],
                      change[l] + 3 * k);
      add_wrench(foot[l].corner[k], change[l] + 3 * k, wrench[l]);
    }
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      twist[0][i] += A[0][i][j] * wrench[0][j] + A_cross[i][j] * wrench[1][j];
      twist[1][i] += A[1][i][j] * wrench[1][j] + A_cross[j][i] * wrench[0][j];
    }
  T old_residual[kNumFeet][kFootRows], after = 0.0;
  for (int l = 0; l < kNumFeet; ++l) {
    for (int i = 0; i < kFootRows; ++i) {
      old_residual[l][i] = foot[l].residual[i];
      foot[l].residual[i] += softness * foot[l].diagonal[i] * change[l][i];
      impulse[l][i] += change[l][i];
    }
    add_twist(twist[l], foot[l]);
    after += contact_defect(mu_forward, mu_sideways, foot[l], impulse[l]);
  }
  for (int l = 0; l < kNumFeet; ++l) {
    for (int i = 0; i < kFootRows; ++i) {
      foot[l].residual[i] = select_less(after, before, foot[l].residual[i], old_residual[l][i]);
      impulse[l][i] -= select_less(after, before, T(0.0), change[l][i]);
    }
    for (int i = 0; i < 6; ++i)
      foot[l].impulse[i] += select_less(after, before, wrench[l][i], T(0.0));
  }
  return select_less(after, before, after, before);
}

}  // namespace sanso::model::SANSO_ISA
