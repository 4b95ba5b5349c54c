// A mixing function: neighbouring inputs give unrelated outputs. Seeds of streams and counters of
// generators go through it.
#pragma once

#include <cstdint>

namespace sanso::math {

/// The increment of SplitMix64: 2^64 divided by the golden ratio, odd.
inline constexpr std::uint64_t kSplitmixStep = 0x9e3779b97f4a7c15ULL;

/// SplitMix64's finaliser (Steele, Lea and Flood 2014), a bijection of 64-bit words.
constexpr std::uint64_t splitmix(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace sanso::math
