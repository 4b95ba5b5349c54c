// The eight lanes of a roll-out in one value, by the compiler's vector extension: one AVX-512 register, two of AVX2, four of NEON.
// Included only by the per-instruction-set sources: every name lives in a namespace of its own (SANSO_ISA), because an
// inline function with one name compiled for two instruction sets would be merged by the linker into one of them.
#pragma once

#ifndef SANSO_ISA
#error "SANSO_ISA must name the instruction set's namespace"
#endif

namespace sanso::mpc::SANSO_ISA {

using Vector8 = double __attribute__((vector_size(64)));
using Vector8Unaligned = double __attribute__((vector_size(64), aligned(8), may_alias));

inline Vector8 load8(const double* p) { return *reinterpret_cast<const Vector8Unaligned*>(p); }
inline void store8(double* p, Vector8 v) { *reinterpret_cast<Vector8Unaligned*>(p) = v; }

}  // namespace sanso::mpc::SANSO_ISA
