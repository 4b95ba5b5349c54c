// A number that counts what is done with it: the kernel's arithmetic is counted by running the
// kernel itself.
#pragma once

#include <cmath>

namespace sanso::bench {

struct Counts {
  long arithmetic = 0;  // additions, subtractions, multiplications
  long division = 0;    // divisions and square roots
  long selection = 0;   // minima, maxima, comparisons with choice
};
inline Counts counts;

struct Counted {
  double v = 0;
  Counted() = default;
  Counted(double s) : v(s) {}  // NOLINT: constants mix with counted numbers, as in the kernel

  friend Counted operator+(Counted a, Counted b) { return ++counts.arithmetic, Counted(a.v + b.v); }
  friend Counted operator-(Counted a, Counted b) { return ++counts.arithmetic, Counted(a.v - b.v); }
  friend Counted operator*(Counted a, Counted b) { return ++counts.arithmetic, Counted(a.v * b.v); }
  friend Counted operator/(Counted a, Counted b) { return ++counts.division, Counted(a.v / b.v); }
  friend Counted operator-(Counted a) { return Counted(-a.v); }
  friend Counted& operator+=(Counted& a, Counted b) { return a = a + b; }
  friend Counted& operator-=(Counted& a, Counted b) { return a = a - b; }
  friend Counted select_less(Counted a, Counted b, Counted yes, Counted no) {
    return ++counts.selection, a.v < b.v ? yes : no;
  }
  friend Counted max_of(Counted a, Counted b) { return ++counts.selection, a.v < b.v ? b : a; }
  friend Counted min_of(Counted a, Counted b) { return ++counts.selection, b.v < a.v ? b : a; }
  friend Counted abs_of(Counted a) { return std::fabs(a.v); }
  friend double largest(Counted a) { return a.v; }
  friend Counted sqrt_of(Counted a) { return ++counts.division, Counted(std::sqrt(a.v)); }
  friend Counted swap_if_odd(Counted n, Counted even, Counted odd) {
    return ++counts.selection, static_cast<long long>(n.v) & 1 ? odd : even;
  }
  friend Counted negate_if_bit1(Counted n, Counted x) {
    return ++counts.selection, static_cast<long long>(n.v) & 2 ? Counted(-x.v) : x;
  }
};

}  // namespace sanso::bench
