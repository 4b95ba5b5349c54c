// What the simulation asks of a number that may be one double or several in step (lanes):
// comparisons, choices and functions. Every operation is the same in a lane as it is alone, so that
// what a shot becomes does not depend on its neighbours.
// Code in this folder is compiled once per instruction set (shared/model/kernel/isa.h): it calls no
// inline function and no template from outside.
#pragma once

#include "shared/model/kernel/exponential.h"
#include "shared/model/kernel/trig.h"

namespace sanso::diagnose::SANSO_ISA {

namespace kernel = sanso::model::SANSO_ISA;
using kernel::abs_of;
using kernel::exp_of;
using kernel::log1p_of;
using kernel::max_of;
using kernel::min_of;
using kernel::power_of;
using kernel::sqrt_of;
template <int W>
using Pack = kernel::Pack<W>;

/// Lanes of a number, the answer to a comparison, and single lanes.
template <class T>
struct Kind {
  static constexpr std::size_t kLanes = 1;
  using Mask = bool;
};
template <int W>
struct Kind<Pack<W>> {
  static constexpr std::size_t kLanes = W;
  using Mask = decltype(typename Pack<W>::Lanes{} < typename Pack<W>::Lanes{});
};
template <class T>
using MaskOf = typename Kind<T>::Mask;

// Lane by lane, and the same for one double: no alignment is asked for.
inline void store(double x, double* out) { *out = x; }
template <int W>
inline void store(Pack<W> x, double* out) {
  for (std::size_t i = 0; i < W; ++i) out[i] = x.v[i];
}
inline void load(const double* in, double& x) { x = *in; }
template <int W>
inline void load(const double* in, Pack<W>& x) {
  for (std::size_t i = 0; i < W; ++i) x.v[i] = in[i];
}

inline bool less(double a, double b) { return a < b; }
template <int W>
inline MaskOf<Pack<W>> less(Pack<W> a, Pack<W> b) {
  return a.v < b.v;
}
inline bool no_more(double a, double b) { return a <= b; }
template <int W>
inline MaskOf<Pack<W>> no_more(Pack<W> a, Pack<W> b) {
  return a.v <= b.v;
}
template <class M>
inline M both(M a, M b) {
  return a & b;
}
template <class M>
inline M either(M a, M b) {
  return a | b;
}
inline bool negated(bool a) { return !a; }
template <class M>
inline M negated(M a) {
  return ~a;
}

inline bool any(bool a) { return a; }
template <class M>
inline bool any(M a) {
  long long found = 0;
  for (unsigned i = 0; i < sizeof(M) / sizeof(double); ++i) found |= a[i];
  return found != 0;
}
#if defined(__AVX512DQ__) && defined(__GNUC__) && !defined(__clang__)
inline bool any(MaskOf<Pack<8>> a) {
  using Words = long long __attribute__((vector_size(64)));
  return __builtin_ia32_cvtq2mask512(__builtin_bit_cast(Words, a)) != 0;
}
#elif defined(__AVX2__) && defined(__GNUC__)
inline bool any(MaskOf<Pack<4>> a) {
  return __builtin_ia32_movmskpd256(__builtin_bit_cast(Pack<4>::Lanes, a)) != 0;
}
#endif

/// yes where `which`, else no.
inline double choose(bool which, double yes, double no) { return which ? yes : no; }
template <int W>
inline Pack<W> choose(MaskOf<Pack<W>> which, Pack<W> yes, Pack<W> no) {
  return Pack<W>(which ? yes.v : no.v);
}

template <class T>
inline T clamped(T x, T low, T high) {
  return min_of(max_of(x, low), high);
}
/// |size| with the sign of `of`; size >= 0.
template <class T>
inline T with_sign(T size, T of) {
  return choose(less(of, T(0.0)), -size, size);
}

}  // namespace sanso::diagnose::SANSO_ISA
