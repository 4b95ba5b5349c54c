// Every random stream of a session comes from one seed, the trial's number and the stream's name,
// never from what ran before: so that a resumed session continues with the same numbers.
#pragma once

#include <cstdint>

#include "shared/math/splitmix.h"

namespace sanso::learn {

enum class Stream : std::uint64_t {
  robot = 1,
  identification = 2,
  residual = 3,
  pushes = 4,
  bring_up = 5,
  ensemble = 6
};

/// Neighbouring inputs, zero included, give unrelated outputs.
constexpr std::uint64_t mixed(std::uint64_t z) { return math::splitmix(z + math::kSplitmixStep); }

constexpr std::uint64_t derived_seed(std::uint64_t seed, std::uint64_t trial, Stream stream) {
  return mixed(mixed(mixed(seed) ^ trial) ^ static_cast<std::uint64_t>(stream));
}

}  // namespace sanso::learn
