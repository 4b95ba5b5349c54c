// Random numbers that are the same on every machine and for every number of threads: a counter, a
// key, a mixing function.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "shared/math/splitmix.h"

namespace sanso::diagnose {

/// Deterministic generator (SplitMix64: Steele, Lea, Flood 2014). Independent streams come from
/// different keys:
/// Random(seed, task index) gives task i the same numbers whichever thread runs it.
class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0)
      : state_(math::splitmix(seed) ^ math::splitmix(stream * math::kSplitmixStep + 1)) {}

  std::uint64_t bits() { return math::splitmix(state_ += math::kSplitmixStep); }
  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  /// Uniform integer in [0, n); n > 0.
  std::size_t below(std::size_t n) {
    return static_cast<std::size_t>(uniform() * static_cast<double>(n));
  }
  /// Standard normal (Box-Muller; the second value is not kept, so that the stream has no hidden
  /// state).
  double normal() {
    const double u = 1.0 - uniform();
    return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * uniform());
  }
  /// +1 or -1 with equal chance.
  double sign() { return (bits() >> 63) != 0 ? 1.0 : -1.0; }

 private:
  std::uint64_t state_;
};

}  // namespace sanso::diagnose
