// FNV-1a, 64 bits: fingerprints of results. Not for authentication.
#pragma once

#include <cstdint>
#include <span>

namespace sanso::learn {

constexpr std::uint64_t fnv1a(std::span<const std::uint8_t> bytes) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (std::uint8_t byte : bytes) hash = (hash ^ byte) * 0x100000001b3ULL;
  return hash;
}

}  // namespace sanso::learn
