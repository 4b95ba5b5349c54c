// The pushes of a campaign: drawn by seed and number alone, inside their ranges.
#include "tools/sweep/pushes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace sanso::sweep {
namespace {

constexpr double kLargest_Ns = 2.4, kFrom_s = 1.0, kTo_s = 6.0;

DrawnPush draw(std::uint64_t seed, int number) {
  return draw_push(seed, number, 0.0, kLargest_Ns, kFrom_s, kTo_s);
}

bool same(const DrawnPush& a, const DrawnPush& b) {
  return a.impulse_Ns == b.impulse_Ns && a.direction_rad == b.direction_rad &&
         a.duration_s == b.duration_s && a.height_m == b.height_m && a.time_s == b.time_s;
}

TEST(DrawnPush, DependsOnSeedAndNumberOnly) {
  const DrawnPush first = draw(1, 3);
  (void)draw(1, 4);  // drawing others in between changes nothing
  EXPECT_TRUE(same(draw(1, 3), first));
  EXPECT_FALSE(same(draw(1, 4), first));
  EXPECT_FALSE(same(draw(2, 3), first));
}

TEST(DrawnPush, ASmallerRangeScalesTheImpulseAndNothingElse) {
  const DrawnPush strong = draw(1, 3), weak = draw_push(1, 3, 0.0, kLargest_Ns / 2, kFrom_s, kTo_s);
  EXPECT_DOUBLE_EQ(weak.impulse_Ns, strong.impulse_Ns / 2);
  EXPECT_EQ(weak.direction_rad, strong.direction_rad);
  EXPECT_EQ(weak.time_s, strong.time_s);
}

TEST(DrawnPush, ALeastImpulseKeepsTheOrderAndNothingElseChanges) {
  for (int number = 0; number < 100; ++number) {
    const DrawnPush any = draw(1, number);
    const DrawnPush strong = draw_push(1, number, 1.2, kLargest_Ns, kFrom_s, kTo_s);
    EXPECT_DOUBLE_EQ(strong.impulse_Ns, 1.2 + any.impulse_Ns * (kLargest_Ns - 1.2) / kLargest_Ns);
    EXPECT_EQ(strong.direction_rad, any.direction_rad);
    EXPECT_EQ(strong.height_m, any.height_m);
    EXPECT_EQ(strong.time_s, any.time_s);
  }
}

TEST(DrawnPush, FillsItsRangesEvenly) {
  constexpr int kCount = 2000;
  double impulse = 0, east = 0, north = 0, height = 0, time = 0;
  std::set<double> different;
  for (int number = 0; number < kCount; ++number) {
    const DrawnPush p = draw(7, number);
    ASSERT_GE(p.impulse_Ns, 0.0);
    ASSERT_LT(p.impulse_Ns, kLargest_Ns);
    ASSERT_GE(p.direction_rad, -M_PI);
    ASSERT_LT(p.direction_rad, M_PI);
    ASSERT_GE(p.height_m, 0.0);
    ASSERT_LT(p.height_m, 0.1);
    ASSERT_GE(p.time_s, kFrom_s);
    ASSERT_LT(p.time_s, kTo_s);
    ASSERT_EQ(p.duration_s, 0.1);
    different.insert(p.impulse_Ns);
    impulse += p.impulse_Ns / kCount;
    east += std::cos(p.direction_rad) / kCount;
    north += std::sin(p.direction_rad) / kCount;
    height += p.height_m / kCount;
    time += p.time_s / kCount;
  }
  EXPECT_EQ(different.size(), static_cast<std::size_t>(kCount));
  // five standard deviations of a mean of 2000 even draws; the seed is fixed, the draws are the
  // same on every machine
  const double tolerance = 5 / std::sqrt(12.0 * kCount);
  EXPECT_NEAR(impulse / kLargest_Ns, 0.5, tolerance);
  EXPECT_NEAR(height / 0.1, 0.5, tolerance);
  EXPECT_NEAR((time - kFrom_s) / (kTo_s - kFrom_s), 0.5, tolerance);
  EXPECT_NEAR(east, 0.0, 5 / std::sqrt(2.0 * kCount));
  EXPECT_NEAR(north, 0.0, 5 / std::sqrt(2.0 * kCount));
}

}  // namespace
}  // namespace sanso::sweep
