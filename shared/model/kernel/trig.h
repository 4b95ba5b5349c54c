// Sine, cosine and the quaternion exponential, the same polynomial for one double and for lanes.
#pragma once

#include "shared/model/kernel/pack.h"

namespace sanso::model::SANSO_ISA {

/// Taylor sums in x^2 by Horner's rule: term k divides by the next factorial step.
/// sine_series(t) = sin(x)/x and cosine_series(t) = cos(x) with t = x^2; `Terms` terms after the
/// leading one.
template <int Terms, class T>
inline T sine_series(T t) {
  T sum = 1.0;
  for (int k = Terms; k >= 1; --k) sum = 1.0 - t * (1.0 / ((2.0 * k) * (2.0 * k + 1.0))) * sum;
  return sum;
}
template <int Terms, class T>
inline T cosine_series(T t) {
  T sum = 1.0;
  for (int k = Terms; k >= 1; --k) sum = 1.0 - t * (1.0 / ((2.0 * k - 1.0) * (2.0 * k))) * sum;
  return sum;
}

/// Sine and cosine of a [rad], |a| up to some thousand turns; error under 2e-16 near zero.
template <class T>
inline void sincos(T a, T& sine, T& cosine) {
  // a = n pi/2 + r with |r| <= pi/4; pi/2 in two parts so that r keeps its precision
  const double two_over_pi = 0.63661977236758134308, pi_half_high = 1.57079632679489655800,
               pi_half_low = 6.12323399573676603587e-17;
  const T n = round_of(a * two_over_pi);
  const T r = (a - n * pi_half_high) - n * pi_half_low;
  const T t = r * r;
  const T s = r * sine_series<7>(t);  // remainder (pi/4)^17 / 17! < 5e-17
  const T c = cosine_series<8>(t);
  sine = negate_if_bit1(n, swap_if_odd(n, s, c));
  cosine = negate_if_bit1(n + 1.0, swap_if_odd(n, c, s));
}

/// quat <- quat * Exp(d), d [rad] in body axes; result of unit length. The series holds for |d| up
/// to about 3 rad.
template <class T>
inline void quat_plus(const T* quat, const T* d, T* out) {
  const T t = 0.25 * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  const T ew = cosine_series<10>(t);
  const T half_sinc = 0.5 * sine_series<10>(t);
  const T ex = half_sinc * d[0], ey = half_sinc * d[1], ez = half_sinc * d[2];
  const T w = quat[0] * ew - quat[1] * ex - quat[2] * ey - quat[3] * ez;
  const T x = quat[0] * ex + quat[1] * ew + quat[2] * ez - quat[3] * ey;
  const T y = quat[0] * ey - quat[1] * ez + quat[2] * ew + quat[3] * ex;
  const T z = quat[0] * ez + quat[1] * ey - quat[2] * ex + quat[3] * ew;
  const T inverse_norm = 1.0 / sqrt_of(w * w + x * x + y * y + z * z);
  out[0] = w * inverse_norm;
  out[1] = x * inverse_norm;
  out[2] = y * inverse_norm;
  out[3] = z * inverse_norm;
}

}  // namespace sanso::model::SANSO_ISA
