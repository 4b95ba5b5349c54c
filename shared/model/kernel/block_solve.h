// The effective inertia of the step, M + armature + h D + h^2 K, as three 6 x 6 blocks: each leg
// and, after the legs are eliminated, the base. A tree without loops has no fill between the legs.
// [Featherstone 2005, branch-induced sparsity]
#pragma once

#include "shared/model/kernel/leg.h"

namespace sanso::model::SANSO_ISA {

/// L D L' in place: unit lower triangle in A, inverse of D in `inverse_d`. Reads the lower triangle
/// only.
template <class T>
inline void factorize6(T (&A)[6][6], T (&inverse_d)[6]) {
#pragma GCC unroll 6
  for (int j = 0; j < 6; ++j) {
    inverse_d[j] = 1.0 / A[j][j];
#pragma GCC unroll 6
    for (int i = j + 1; i < 6; ++i) {
      const T l = A[i][j] * inverse_d[j];
#pragma GCC unroll 6
      // column j is still unscaled below row i
      for (int k = j + 1; k <= i; ++k) A[i][k] -= l * A[k][j];
    }
#pragma GCC unroll 6
    for (int i = j + 1; i < 6; ++i) A[i][j] = A[i][j] * inverse_d[j];
  }
}

/// X <- L^-1 X for N columns, X[row][column].
template <int N, class T>
inline void forward6(const T (&L)[6][6], T (&X)[6][N]) {
#pragma GCC unroll 6
  for (int i = 1; i < 6; ++i)
#pragma GCC unroll 6
    for (int k = 0; k < i; ++k)
#pragma GCC unroll 12
      for (int c = 0; c < N; ++c) X[i][c] -= L[i][k] * X[k][c];
}

template <class S, class T>
inline void forward6(const S (&L)[6][6], T (&x)[6]) {
#pragma GCC unroll 6
  for (int i = 1; i < 6; ++i)
#pragma GCC unroll 6
    for (int k = 0; k < i; ++k) x[i] -= L[i][k] * x[k];
}

/// x <- L^-T x.
template <class S, class T>
inline void backward6(const S (&L)[6][6], T (&x)[6]) {
#pragma GCC unroll 6
  for (int i = 4; i >= 0; --i)
#pragma GCC unroll 6
    for (int k = i + 1; k < 6; ++k) x[i] -= L[k][i] * x[k];
}

/// out -= X' D^-1 Y, entries [i][j] for all i, or only j <= i when `Lower`.
template <bool Lower, class T>
inline void subtract_product(const T (&X)[6][6], const T (&inverse_d)[6], const T (&Y)[6][6],
                             T (&out)[6][6]) {
#pragma GCC unroll 6
  for (int i = 0; i < 6; ++i)  // a row of `out` at a time stays in registers
#pragma GCC unroll 6
    for (int k = 0; k < 6; ++k) {
      const T scaled = X[k][i] * inverse_d[k];
#pragma GCC unroll 6
      for (int j = 0; j < (Lower ? i + 1 : 6); ++j) out[i][j] -= scaled * Y[k][j];
    }
}

/// A += Y' D^-1 Z.
template <class T>
inline void add_weighted_product(const T (&Y)[6][6], const T (&inverse_d)[6], const T (&Z)[6][6],
                                 T (&A)[6][6]) {
#pragma GCC unroll 6
  for (int i = 0; i < 6; ++i)
#pragma GCC unroll 6
    for (int k = 0; k < 6; ++k) {
      const T scaled = Y[k][i] * inverse_d[k];
#pragma GCC unroll 6
      for (int j = 0; j < 6; ++j) A[i][j] += scaled * Z[k][j];
    }
}

/// A = Y' D^-1 Y + Z' E^-1 Z, symmetric to the last bit.
template <class T>
inline void weighted_squares(const T (&Y)[6][6], const T (&inverse_d)[6], const T (&Z)[6][6],
                             const T (&inverse_e)[6], T (&A)[6][6]) {
#pragma GCC unroll 6
  for (int i = 0; i < 6; ++i) {
    T row[6];
#pragma GCC unroll 6
    for (int j = 0; j <= i; ++j) row[j] = T(0.0);
#pragma GCC unroll 6
    for (int k = 0; k < 6; ++k) {
      const T y = Y[k][i] * inverse_d[k], z = Z[k][i] * inverse_e[k];
#pragma GCC unroll 6
      for (int j = 0; j <= i; ++j) row[j] += y * Y[k][j] + z * Z[k][j];
    }
#pragma GCC unroll 6
    for (int j = 0; j <= i; ++j) A[i][j] = A[j][i] = row[j];
  }
}

}  // namespace sanso::model::SANSO_ISA
