// What servos are born with: repeatable, of the deviation asked for, and none where none is asked.
#include "tools/plant/servo_birth.h"

#include <gtest/gtest.h>

namespace sanso::plant {
namespace {

TEST(ServoBirth, IsExactWhereAWorldAsksForNothing) {
  for (int id = 1; id <= 20; ++id) {
    EXPECT_EQ(birth_of({}, id).zero_offset_rad, 0.0);
    EXPECT_EQ(birth_of({}, id).gain_scale, 1.0);
  }
}

TEST(ServoBirth, IsKeptForLifeAndHasTheDeviationAskedFor) {
  ServoParameters s;
  s.zero_offset_rad = 0.0122;
  s.gain_spread = 0.05;
  double offsets = 0.0, gains = 0.0;
  int count = 0;
  for (s.spread_seed = 0; s.spread_seed < 200; ++s.spread_seed)
    for (int id = 1; id <= 20; ++id, ++count) {
      const ServoBirth birth = birth_of(s, id);
      EXPECT_EQ(birth.zero_offset_rad, birth_of(s, id).zero_offset_rad);
      offsets += birth.zero_offset_rad * birth.zero_offset_rad;
      gains += (birth.gain_scale - 1.0) * (birth.gain_scale - 1.0);
    }
  // of 4000 draws: 1.1 % is one deviation of the estimate
  EXPECT_NEAR(std::sqrt(offsets / count), s.zero_offset_rad, 0.05 * s.zero_offset_rad);
  EXPECT_NEAR(std::sqrt(gains / count), s.gain_spread, 0.05 * s.gain_spread);
}

TEST(ServoBirth, LeftIsTheSideOfEvenIds) {
  ServoParameters s;
  s.left_gain_scale = 1.1;
  EXPECT_EQ(birth_of(s, 7).gain_scale, 1.0);
  EXPECT_EQ(birth_of(s, 8).gain_scale, 1.1);
}

}  // namespace
}  // namespace sanso::plant
