// Tangent operators and what they are made of, for several states in step: x ⊖ y. Per
// instruction set.
#pragma once

#include "host/mpc/problem.h"
#include "shared/model/kernel/step.h"

namespace sanso::mpc::SANSO_ISA {

namespace kernel = sanso::model::SANSO_ISA;
using Lanes = kernel::Pack<8>;             // of a linearisation
using Quad = kernel::Pack<kRollOutLanes>;  // of a roll-out

/// Logarithm of conj(b) * a [rad], body axes of b: the twin of math::quat_minus. |result| <= pi.
template <class T>
inline void quat_minus(const T* a, const T* b, T* out) {
  const T w0 = b[0] * a[0] + b[1] * a[1] + b[2] * a[2] + b[3] * a[3];
  const T x0 = b[0] * a[1] - b[1] * a[0] - b[2] * a[3] + b[3] * a[2];
  const T y0 = b[0] * a[2] - b[2] * a[0] - b[3] * a[1] + b[1] * a[3];
  const T z0 = b[0] * a[3] - b[3] * a[0] - b[1] * a[2] + b[2] * a[1];
  const T sign = kernel::select_less(w0, T(0.0), T(-1.0), T(1.0));  // the shorter way round
  const T w = sign * w0;
  // angle = 2 atan2(n, w) = 8 atan(t) after halving twice: t = n * half2 with n the length of the
  // vector part
  const T n2 = x0 * x0 + y0 * y0 + z0 * z0;
  const T half1 = 1.0 / (1.0 + w);
  const T half2 = half1 / (1.0 + kernel::sqrt_of(1.0 + n2 * half1 * half1));
  const T t2 = n2 * half2 * half2;  // <= tan(pi/8)^2 = 0.172
  constexpr int kTerms = 19;        // 0.172^20 / 41 < 2e-17
  T series = 1.0 / (2.0 * kTerms + 1.0);
  for (int k = kTerms - 1; k >= 0; --k) series = 1.0 / (2.0 * k + 1.0) - t2 * series;
  const T factor = sign * (8.0 * half2) * series;
  out[0] = factor * x0;
  out[1] = factor * y0;
  out[2] = factor * z0;
}

/// a ⊖ b for states in the order of state_layout.h.
template <class T>
inline void state_minus(const T* a, const T* b, T* out) {
  for (int i = 0; i < 3; ++i) out[i] = a[i] - b[i];
  quat_minus(a + 3, b + 3, out + 3);
  for (int i = 6; i < kNdx; ++i) out[i] = a[i + 1] - b[i + 1];
}

/// Small rotations (|d| < 0.1 rad) between nearly equal orientations: 2 asin-free, error d^5.
template <class T>
inline void quat_minus_small(const T* a, const T* b, T* out) {
  const T w = b[0] * a[0] + b[1] * a[1] + b[2] * a[2] + b[3] * a[3];
  const T x = b[0] * a[1] - b[1] * a[0] - b[2] * a[3] + b[3] * a[2];
  const T y = b[0] * a[2] - b[2] * a[0] - b[3] * a[1] + b[1] * a[3];
  const T z = b[0] * a[3] - b[3] * a[0] - b[1] * a[2] + b[2] * a[1];
  // asin(n)/n = 1 + n^2/6 + 3 n^4/40; the factor 2/w-sign keeps q and -q equal
  const T n2 = x * x + y * y + z * z;
  const T factor =
      kernel::select_less(w, T(0.0), T(-2.0), T(2.0)) * (1.0 + n2 * (1.0 / 6.0 + n2 * 0.075));
  out[0] = factor * x;
  out[1] = factor * y;
  out[2] = factor * z;
}

}  // namespace sanso::mpc::SANSO_ISA
