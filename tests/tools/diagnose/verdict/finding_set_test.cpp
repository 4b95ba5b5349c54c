// Sets: what stands beside a name that the data do not tell from it, and what is only a part of it.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/explain/regimes.h"
#include "tools/diagnose/verdict/finding.h"

namespace sanso::diagnose {
namespace {

using namespace test;

std::vector<Finding> found(const EffectEntry& hidden, const std::vector<std::string>& tried) {
  const SmallComparison c = compared(pendulum(kNoisyServo), {hidden}, tried, 5, 3);
  const Selection selection = select(c.problem, c.library, SelectOptions{});
  return findings_of(c.library, selection, find_regimes(*c.problem));
}

bool is_in(const std::vector<std::string>& set, const char* name) {
  return std::find(set.begin(), set.end(), name) != set.end();
}

/// A payload makes any load of one joint that another centre of mass makes, and is another cause.
TEST(Set, AWeightStandsBesideTheCentreOfMassThatItMayBe) {
  const std::vector<Finding> all =
      found(hidden("link_com", "arm", {{"x", 0.012}}), {"link_com", "payload"});
  ASSERT_EQ(all.size(), 1U);
  EXPECT_TRUE(is_in(all.front().one_of, "link_com"));
  EXPECT_TRUE(is_in(all.front().one_of, "payload"));
  EXPECT_EQ(all.front().status, VerdictStatus::one_of);
}

/// Stribeck's friction at a speed that is never reached is dry friction: no second cause.
TEST(Set, ALawThatIsTheNamesOwnWithMoreNumbersDoesNot) {
  const std::vector<Finding> all = found(hidden("coulomb_friction", "a", {{"coulomb", 0.08}}),
                                         {"coulomb_friction", "stribeck_friction"});
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all.front().one_of, std::vector<std::string>{"coulomb_friction"});
  EXPECT_EQ(all.front().status, VerdictStatus::confirmed);
}

}  // namespace
}  // namespace sanso::diagnose
