// FixedVector keeps its capacity and says when it is full; Result and time conversions are
// exact.
#include "shared/base/fixed_vector.h"

#include <gtest/gtest.h>

#include "shared/base/status.h"
#include "shared/base/time.h"

namespace sanso {
namespace {

TEST(FixedVector, ExactFitThenFull) {
  FixedVector<int, 2> v;
  EXPECT_TRUE(v.try_push(1));
  EXPECT_TRUE(v.try_push(2));
  EXPECT_FALSE(v.try_push(3)) << "one too many";
  ASSERT_EQ(v.size(), 2u);
  EXPECT_EQ(v[1], 2) << "a refused push changes nothing";
}

TEST(FixedVector, AppendIsAllOrNothing) {
  FixedVector<int, 3> v;
  const int two[] = {1, 2};
  EXPECT_TRUE(v.try_append(two));
  EXPECT_FALSE(v.try_append(two));
  EXPECT_EQ(v.size(), 2u);
}

TEST(FixedVector, ResizeInitialisesWhatItAdds) {
  FixedVector<int, 3> v;
  ASSERT_TRUE(v.try_push(7));
  v.clear();
  ASSERT_TRUE(v.try_resize(2));
  EXPECT_EQ(v[0], 0) << "an element that was cleared does not come back";
  EXPECT_FALSE(v.try_resize(4));
}

TEST(Result, CarriesValueOrStatus) {
  const Result<int> good(3), bad(Status::timeout);
  EXPECT_TRUE(good.ok());
  EXPECT_EQ(*good, 3);
  EXPECT_FALSE(bad);
  EXPECT_STREQ(to_string(bad.status()), "timeout");
}

TEST(Time, SecondsRoundTripToTheNanosecond) {
  for (const Nanoseconds t :
       {Nanoseconds{0}, Nanoseconds{1}, Nanoseconds{-1}, 3 * kSecond + 7, -kTickPeriod}) {
    EXPECT_EQ(from_seconds(to_seconds(t)), t);
  }
}

}  // namespace
}  // namespace sanso
