// The mixing function against published values.
#include "shared/math/splitmix.h"

#include <gtest/gtest.h>

namespace sanso::math {
namespace {

TEST(Splitmix, HasTheValuesOfTheReference) {  // of the generator with seed 1234567
  const std::uint64_t expected[] = {6457827717110365317ULL, 3203168211198807973ULL,
                                    9817491932198370423ULL};
  std::uint64_t state = 1234567;
  for (const std::uint64_t value : expected) EXPECT_EQ(splitmix(state += kSplitmixStep), value);
}

}  // namespace
}  // namespace sanso::math
