// FNV-1a against its published test vectors.
#include "shared/files/hash.h"

#include <gtest/gtest.h>

#include <string_view>

namespace sanso::files {
namespace {

std::uint64_t of(std::string_view text, std::uint64_t hash = kFnv1aBasis) {
  return fnv1a({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, hash);
}

TEST(Hash, HasTheValuesOfTheReference) {  // Fowler, Noll, Vo: test vectors of FNV-1a, 64 bits
  EXPECT_EQ(of(""), 14695981039346656037ULL);
  EXPECT_EQ(of("a"), 0xaf63dc4c8601ec8cULL);
  EXPECT_EQ(of("foobar"), 0x85944171f73967e8ULL);
}

TEST(Hash, GoesOnWhereItStopped) { EXPECT_EQ(of("bar", of("foo")), of("foobar")); }

}  // namespace
}  // namespace sanso::files
