// W doubles that are computed in step (lanes), and the few operations that differ between a lane
// pack and one double.
#pragma once

#include "shared/model/kernel/isa.h"

namespace sanso::model::SANSO_ISA {

// vector types by width; written out because the attribute does not depend on template parameters
// in every compiler
template <int W>
struct Vectors;
#define SANSO_VECTORS(w)                                          \
  template <>                                                     \
  struct Vectors<w> {                                             \
    typedef double Lanes __attribute__((vector_size(8 * (w))));   \
    typedef long long Mask __attribute__((vector_size(8 * (w)))); \
  };
SANSO_VECTORS(2)
SANSO_VECTORS(4)
SANSO_VECTORS(8)
#undef SANSO_VECTORS

template <int W>
struct Pack {
  using Lanes = typename Vectors<W>::Lanes;
  using Mask = typename Vectors<W>::Mask;
  Lanes v;

  Pack() = default;
  Pack(double s) : v(Lanes{} + s) {}  // NOLINT: a constant means itself in every lane
  explicit Pack(Lanes lanes) : v(lanes) {}
};

#define SANSO_PACK_OPERATOR(op)                      \
  template <int W>                                   \
  inline Pack<W> operator op(Pack<W> a, Pack<W> b) { \
    return Pack<W>(a.v op b.v);                      \
  }                                                  \
  template <int W>                                   \
  inline Pack<W> operator op(Pack<W> a, double b) {  \
    return Pack<W>(a.v op b);                        \
  }                                                  \
  template <int W>                                   \
  inline Pack<W> operator op(double a, Pack<W> b) {  \
    return Pack<W>(a op b.v);                        \
  }
SANSO_PACK_OPERATOR(+)
SANSO_PACK_OPERATOR(-)
SANSO_PACK_OPERATOR(*)
SANSO_PACK_OPERATOR(/)
#undef SANSO_PACK_OPERATOR

template <int W>
inline Pack<W> operator-(Pack<W> a) {
  return Pack<W>(-a.v);
}
template <int W>
inline Pack<W>& operator+=(Pack<W>& a, Pack<W> b) {
  a.v += b.v;
  return a;
}
template <int W>
inline Pack<W>& operator-=(Pack<W>& a, Pack<W> b) {
  a.v -= b.v;
  return a;
}

// a < b ? yes : no, lane by lane
inline double select_less(double a, double b, double yes, double no) { return a < b ? yes : no; }
template <int W>
inline Pack<W> select_less(Pack<W> a, Pack<W> b, Pack<W> yes, Pack<W> no) {
  return Pack<W>(a.v < b.v ? yes.v : no.v);
}

// lane by lane
inline double max_of(double a, double b) { return a < b ? b : a; }
inline double min_of(double a, double b) { return b < a ? b : a; }
inline double sqrt_of(double a) { return __builtin_sqrt(a); }
inline double abs_of(double a) { return __builtin_fabs(a); }
template <int W>
inline Pack<W> max_of(Pack<W> a, Pack<W> b) {
  return Pack<W>(a.v < b.v ? b.v : a.v);
}
template <int W>
inline Pack<W> min_of(Pack<W> a, Pack<W> b) {
  return Pack<W>(b.v < a.v ? b.v : a.v);
}
#if defined(__AVX512F__) && defined(__GNUC__) && !defined(__clang__)
// one instruction where the compiler would write a comparison and a blend (all lanes, rounding mode
// as set)
inline Pack<8> max_of(Pack<8> a, Pack<8> b) {
  return Pack<8>(__builtin_ia32_maxpd512_mask(a.v, b.v, a.v, -1, 4));
}
inline Pack<8> min_of(Pack<8> a, Pack<8> b) {
  return Pack<8>(__builtin_ia32_minpd512_mask(a.v, b.v, a.v, -1, 4));
}
#endif
template <int W>
inline Pack<W> abs_of(Pack<W> a) {
  return max_of(a, -a);
}
template <int W>
inline Pack<W> sqrt_of(Pack<W> a) {
  Pack<W> r;
  for (int i = 0; i < W; ++i) r.v[i] = __builtin_sqrt(a.v[i]);
  return r;
}

/// The largest lane of a number that is not negative. Lanes that left the finite numbers count as
/// 0: they are lost already.
inline double largest(double a) { return a > 0.0 ? a : 0.0; }
template <int W>
inline double largest(Pack<W> a) {
  double most = 0.0;
  for (int i = 0; i < W; ++i) most = a.v[i] > most ? a.v[i] : most;
  return most;
}

/// Quadrant helpers of sincos: `n` is a whole number. Odd n swaps sine and cosine; bit 1 of n turns
/// a sign.
inline bool is_odd(double n) { return static_cast<long long>(n) & 1; }
inline double swap_if_odd(double n, double even, double odd) { return is_odd(n) ? odd : even; }
inline double negate_if_bit1(double n, double x) {
  return (static_cast<long long>(n) & 2) ? -x : x;
}
template <int W>
inline Pack<W> swap_if_odd(Pack<W> n, Pack<W> even, Pack<W> odd) {
  const auto i = __builtin_convertvector(n.v, typename Pack<W>::Mask);
  return Pack<W>((i & 1) != 0 ? odd.v : even.v);
}
template <int W>
inline Pack<W> negate_if_bit1(Pack<W> n, Pack<W> x) {
  const auto i = __builtin_convertvector(n.v, typename Pack<W>::Mask);
  return Pack<W>((i & 2) != 0 ? -x.v : x.v);
}

/// Nearest whole number, |a| < 2^51: the classical trick with 1.5 x 2^52, which leaves no fraction
/// bits.
template <class T>
inline T round_of(T a) {
  const double magic = 6755399441055744.0;
  return (a + magic) - magic;
}

}  // namespace sanso::model::SANSO_ISA
