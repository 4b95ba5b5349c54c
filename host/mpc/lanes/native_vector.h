// Vectors as wide as the registers of the instruction set that is compiled for, by the compiler's
// vector extension, and the two shapes of fixed-size products that the planner needs. Wider vectors
// than registers would be correct too, but compilers keep them in memory: on AVX2 that cost a
// factor of ten.
// Included only by the per-instruction-set sources: every name lives in a namespace of its own
// (SANSO_ISA), because an inline function with one name compiled for two instruction sets would be
// merged by the linker into one of them.
#pragma once

#ifndef SANSO_ISA
#error "SANSO_ISA must name the instruction set's namespace"
#endif

namespace sanso::mpc::SANSO_ISA {

#if defined(__AVX512F__)
inline constexpr int kVectorBytes = 64;
#elif defined(__AVX2__)
inline constexpr int kVectorBytes = 32;
#else
inline constexpr int kVectorBytes = 16;  // SSE2, NEON
#endif

/// What differs between the element types; Memory is a vector as it may stand anywhere in an array.
template <class Element>
struct Native;
template <>
struct Native<double> {
  typedef double Vector __attribute__((vector_size(kVectorBytes)));
  typedef double Memory __attribute__((vector_size(kVectorBytes), aligned(8), may_alias));
};
template <>
struct Native<float> {
  typedef float Vector __attribute__((vector_size(kVectorBytes)));
  typedef float Memory __attribute__((vector_size(kVectorBytes), aligned(4), may_alias));
};
using Doubles = Native<double>::Vector;
using Floats = Native<float>::Vector;
typedef int FloatBits __attribute__((vector_size(kVectorBytes)));

/// Elements in a vector.
template <class Element>
inline constexpr int kWidth = kVectorBytes / static_cast<int>(sizeof(Element));

template <class Element>
inline typename Native<Element>::Vector load(const Element* p) {
  return *reinterpret_cast<const typename Native<Element>::Memory*>(p);
}
template <class Element>
inline void store(Element* p, typename Native<Element>::Vector v) {
  *reinterpret_cast<typename Native<Element>::Memory*>(p) = v;
}

/// Vectors of one row that are summed at once: with four rows the sums fill half of the registers.
template <class Element, int Columns>
inline constexpr int kBlock = kVectorBytes == 64 ? Columns / kWidth<Element> : 2;

enum class Start { at_zero, at_out };

/// One block of multiply(): `Rows` x `Vectors` sums in registers.
template <int Rows, int Vectors, Start start, class Element>
inline void multiply_block(const Element* left, int left_row_stride, int left_k_stride,
                           const Element* right, int right_stride, int inner, Element* out,
                           int out_stride) {
  constexpr int w = kWidth<Element>;
  using Vector = typename Native<Element>::Vector;
  Vector sum[Rows][Vectors];
  for (int r = 0; r < Rows; ++r)
    for (int c = 0; c < Vectors; ++c)
      sum[r][c] = start == Start::at_out ? load(out + r * out_stride + w * c) : Vector{};
  for (int k = 0; k < inner; ++k) {
    Vector row[Vectors];
    for (int c = 0; c < Vectors; ++c) row[c] = load(right + k * right_stride + w * c);
    for (int r = 0; r < Rows; ++r) {
      const Element factor = left[r * left_row_stride + k * left_k_stride];
      for (int c = 0; c < Vectors; ++c) sum[r][c] += factor * row[c];
    }
  }
  for (int r = 0; r < Rows; ++r)
    for (int c = 0; c < Vectors; ++c) store(out + r * out_stride + w * c, sum[r][c]);
}

/// out[r][0 .. Columns) = start + sum_k left(r, k) right[k][0 .. Columns) for Rows rows; Columns a
/// multiple of 8 doubles or 16 floats. The strides of `left` let the same kernel read a matrix or
/// its transpose.
template <int Rows, int Columns, Start start, class Element>
inline void multiply(const Element* left, int left_row_stride, int left_k_stride,
                     const Element* right, int right_stride, int inner, Element* out,
                     int out_stride) {
  constexpr int block = kBlock<Element, Columns>;
  static_assert(Columns % (block * kWidth<Element>) == 0);
  for (int c = 0; c < Columns; c += block * kWidth<Element>)
    multiply_block<Rows, block, start>(left, left_row_stride, left_k_stride, right + c,
                                       right_stride, inner, out + c, out_stride);
}

}  // namespace sanso::mpc::SANSO_ISA
