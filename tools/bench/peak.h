// What this core can do at most: fused multiply-adds on registers only, in the widest vectors of
// the named instruction set.
#pragma once

namespace sanso::bench {

/// Measured double-precision peak of one core [FLOP/s] for "avx512", "avx2" or "portable"; 0 when
/// the machine lacks it.
double peak_flops(const char* isa);

}  // namespace sanso::bench
