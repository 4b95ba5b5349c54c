// FNV-1a, 64 bits: fingerprints of results and of data. Not for authentication.
#pragma once

#include <cstdint>
#include <span>

namespace sanso::files {

constexpr std::uint64_t kFnv1aBasis = 0xcbf29ce484222325ULL;  // 14695981039346656037

/// The fingerprint of `bytes`, or of what gave `hash` followed by `bytes`.
constexpr std::uint64_t fnv1a(std::span<const std::uint8_t> bytes,
                              std::uint64_t hash = kFnv1aBasis) {
  for (std::uint8_t byte : bytes) hash = (hash ^ byte) * 0x100000001b3ULL;
  return hash;
}

}  // namespace sanso::files
