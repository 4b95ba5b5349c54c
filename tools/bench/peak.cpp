// Chains of independent multiply-adds, long enough to fill the pipeline; the fastest of several
// runs counts.
#include "tools/bench/peak.h"

#include <algorithm>
#include <chrono>
#include <cstring>

namespace sanso::bench {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int kRounds = 200000;
constexpr int kChains = 16;  // independent sums: latency 4 x 2 units needs at least 8

volatile double sink;

// Chains of sum = sum * a + b; a vector type per instruction set, the loop is the same.
template <class Vector>
[[gnu::always_inline]] inline void multiply_add() {
  Vector sum[kChains], a = Vector{} + 0.999, b = Vector{} + 1e-3;
  for (int c = 0; c < kChains; ++c) sum[c] = Vector{} + c;
  for (int r = 0; r < kRounds; ++r) {
#pragma GCC unroll 16
    for (int c = 0; c < kChains; ++c) sum[c] = sum[c] * a + b;
  }
  double total = 0;
  for (int c = 0; c < kChains; ++c) total += sum[c][0];
  sink = total;
}

typedef double Vector2 __attribute__((vector_size(16)));
void run_portable() { multiply_add<Vector2>(); }
#ifdef __x86_64__
typedef double Vector4 __attribute__((vector_size(32)));
typedef double Vector8 __attribute__((vector_size(64)));
[[gnu::target("avx2,fma")]] void run_avx2() { multiply_add<Vector4>(); }
[[gnu::target("avx512f,fma")]] void run_avx512() { multiply_add<Vector8>(); }
#endif

double fastest(void (*run)(), int width) {
  double best = 0;
  for (int i = 0; i < 7; ++i) {
    const auto start = Clock::now();
    run();
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    best = std::max(best, 2.0 * width * kChains * kRounds / seconds);
  }
  return best;
}

}  // namespace

double peak_flops(const char* isa) {
#ifdef __x86_64__
  if (std::strcmp(isa, "avx512") == 0)
    return __builtin_cpu_supports("avx512f") ? fastest(run_avx512, 8) : 0;
  if (std::strcmp(isa, "avx2") == 0)
    return __builtin_cpu_supports("avx2") ? fastest(run_avx2, 4) : 0;
#endif
  return std::strcmp(isa, "portable") == 0 ? fastest(run_portable, 2) : 0;
}

}  // namespace sanso::bench
