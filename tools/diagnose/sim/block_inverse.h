// Inverse of one branch's inertia, in lanes.
#pragma once

#include "tools/diagnose/sim/lane_math.h"
#include "tools/diagnose/sim/tree_figures.h"

namespace sanso::diagnose::SANSO_ISA {

/// Where entry (i, j) of a symmetric matrix stands of which the lower triangle is written.
inline std::size_t in_lower(std::size_t i, std::size_t j) {
  return i < j ? j * kMaxJoints + i : i * kMaxJoints + j;
}

/// Inverse of the symmetric positive definite block [b, e) given by its lower triangle; in place
/// scratch L. No pivot is taken for less than `least`.
template <class T>
inline void invert_block(T* L, T* inverse, std::size_t b, std::size_t e, T least) {
  const auto at = [](std::size_t i, std::size_t j) { return i * kMaxJoints + j; };
  if (e - b == 1) {
    inverse[at(b, b)] = 1.0 / max_of(L[at(b, b)], least);
    return;
  }
  for (std::size_t j = b; j < e; ++j) {  // Cholesky
    for (std::size_t i = j; i < e; ++i) {
      T sum = L[at(i, j)];
      for (std::size_t k = b; k < j; ++k) sum -= L[at(i, k)] * L[at(j, k)];
      // the diagonal holds reciprocals: one division a joint
      L[at(i, j)] = i == j ? 1.0 / sqrt_of(max_of(sum, least)) : sum * L[at(j, j)];
    }
  }
  for (std::size_t j = b; j < e; ++j) {  // inverse of L, then L^-T L^-1
    for (std::size_t i = j + 1; i < e; ++i) {
      T sum = 0.0;
      for (std::size_t k = j; k < i; ++k) sum -= L[at(i, k)] * L[at(k, j)];
      L[at(i, j)] = sum * L[at(i, i)];
    }
  }
  for (std::size_t i = b; i < e; ++i) {
    for (std::size_t j = b; j <= i; ++j) {
      T sum = 0.0;
      for (std::size_t k = i; k < e; ++k) sum += L[at(k, i)] * L[at(k, j)];
      inverse[at(i, j)] = inverse[at(j, i)] = sum;
    }
  }
}

}  // namespace sanso::diagnose::SANSO_ISA
