// Every random stream of a session comes from one seed, the trial's number and the stream's name,
// never from what ran before: so that a resumed session continues with the same numbers.
#pragma once

#include <cstdint>

namespace sanso::learn {

enum class Stream : std::uint64_t { robot = 1, identification = 2, residual = 3, pushes = 4 };

/// SplitMix64 finaliser (Steele, Lea and Flood 2014): neighbouring inputs give unrelated outputs.
constexpr std::uint64_t mixed(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

constexpr std::uint64_t derived_seed(std::uint64_t seed, std::uint64_t trial, Stream stream) {
  return mixed(mixed(mixed(seed) ^ trial) ^ static_cast<std::uint64_t>(stream));
}

}  // namespace sanso::learn
