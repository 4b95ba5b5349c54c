// The sealed answer: encrypted, so that nothing reads it by accident, with a hash that is printed
// when it is made, so that nobody changes it afterwards. The key is derived here, from the file's
// salt; only reveal calls open_seal().
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sanso::conceal {

std::vector<std::uint8_t> make_seal(const std::string& answer);
/// Throws plant::WorldError when the bytes are no seal or were changed.
std::string open_seal(std::span<const std::uint8_t> sealed);
/// BLAKE2b-256 of the sealed bytes, hexadecimal.
std::string seal_hash(std::span<const std::uint8_t> sealed);

}  // namespace sanso::conceal
