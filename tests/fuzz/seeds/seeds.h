// The beginnings of the fuzzers: what our own encoders make, target by target. The same bytes lie
// in tests/fuzz/corpus, beside inputs that once failed; a test compares.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace sanso::fuzz {

using Bytes = std::vector<std::uint8_t>;
/// target -> name of the seed -> bytes
std::map<std::string, std::map<std::string, Bytes>> seeds();

}  // namespace sanso::fuzz
