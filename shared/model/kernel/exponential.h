// Exponential, logarithm and power: the same polynomials for one double and for lanes, from the
// bits of a double's exponent.
#pragma once

#include "shared/model/kernel/pack.h"

namespace sanso::model::SANSO_ISA {

/// A number's bits, lane by lane, and the number that has them.
template <class T>
struct BitsOf {
  using Words = long long;
  static Words of(double a) { return __builtin_bit_cast(Words, a); }
  static double number(Words bits) { return __builtin_bit_cast(double, bits); }
};
template <int W>
struct BitsOf<Pack<W>> {
  using Words = typename Pack<W>::Mask;
  static Words of(Pack<W> a) { return __builtin_bit_cast(Words, a.v); }
  static Pack<W> number(Words bits) {
    return Pack<W>(__builtin_bit_cast(typename Pack<W>::Lanes, bits));
  }
};

inline constexpr double kLn2High = 6.93147180369123816490e-01,
                        kLn2Low = 1.90821492927058770002e-10;  // their sum: ln 2

/// e^a for |a| < 700; relative error under 1e-15.
template <class T>
inline T exp_inside(T a) {
  const double log2e = 1.4426950408889634074;
  const T n = round_of(a * log2e);
  const T r = (a - n * kLn2High) - n * kLn2Low;  // |r| <= ln 2 / 2
  T sum = 1.0;
  for (int k = 13; k >= 1; --k) sum = 1.0 + r * (1.0 / k) * sum;
  // 2^n: the exponent field of a double. Beside 1.5 x 2^52 a whole number is its own bits.
  const double biased = 6755399441055744.0 + 1023.0;
  return sum * BitsOf<T>::number(BitsOf<T>::of(n + biased) << 52);
}

/// e^a of any number; beyond |a| = 700 that of 700.
template <class T>
inline T exp_of(T a) {
  return exp_inside(min_of(max_of(a, T(-700.0)), T(700.0)));
}

/// ln a for a > 0; of 0 the finite -709. Absolute error under 1e-15 near 1, relative elsewhere.
template <class T>
inline T log_of(T a) {
  using Bits = BitsOf<T>;
  const auto bits = Bits::of(a);
  const double two52 = 4503599627370496.0, root2 = 1.41421356237309514547;
  const T e = Bits::number((bits >> 52) | 0x4330000000000000LL) - (two52 + 1023.0);
  const T m = Bits::number((bits & 0x000fffffffffffffLL) | 0x3ff0000000000000LL);  // [1, 2)
  const T exponent = select_less(T(root2), m, e + 1.0, e);
  const T mantissa = select_less(T(root2), m, 0.5 * m, m);
  const T s = (mantissa - 1.0) / (mantissa + 1.0), t = s * s;  // |s| < 0.172
  constexpr int kTerms = 11;                                   // 0.0295^12 / 25 < 2e-20
  T sum = 1.0 / (2.0 * kTerms + 1.0);
  for (int k = kTerms - 1; k >= 0; --k) sum = 1.0 / (2.0 * k + 1.0) + t * sum;
  return exponent * kLn2High + (exponent * kLn2Low + 2.0 * s * sum);
}

/// ln(1 + a) for 0 <= a; beyond 1e300 that of 1e300.
template <class T>
inline T log1p_of(T a) {
  const T x = min_of(a, T(1e300));
  const T u = 1.0 + x;
  return log_of(u) + (x - (u - 1.0)) / u;  // what the sum rounded off
}

/// a^exponent for a >= 0, exponent > 0; of 0 less than 1e-100 for exponents from 1/3 on.
template <class T>
inline T power_of(T a, double exponent) {
  if (exponent == 1.0) return a;
  return exp_of(exponent * log_of(a));
}

}  // namespace sanso::model::SANSO_ISA
