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

const Rival& rival(const Finding& finding, const char* name) {
  const auto it = std::find_if(finding.rivals.begin(), finding.rivals.end(),
                               [&](const Rival& r) { return r.effect == name; });
  EXPECT_NE(it, finding.rivals.end()) << name;
  return *it;
}

Finding weight_found(double mass) {
  const std::vector<Finding> all =
      found(hidden("payload", "arm", {{"mass", mass}, {"z", -0.2}}), {"link_mass", "payload"});
  EXPECT_EQ(all.size(), 1U);
  const Finding& finding = all.front();
  EXPECT_EQ(finding.effect, "payload");
  EXPECT_GT(rival(finding, "link_mass").behind_in_se, 3.0) << "the premise: beyond chance";
  return finding;
}

/// Nobody's link is its model to the last gram: what a heavier link leaves of a payload, 1.4 %, may
/// be how its mass is spread. Not so what it leaves of a larger one, 5 %.
TEST(Set, ARivalThatLeavesLessThanALawMayBeOffByStands) {
  EXPECT_TRUE(is_in(weight_found(0.15).one_of, "link_mass"));
  EXPECT_EQ(weight_found(0.19).status, VerdictStatus::confirmed);
}

std::vector<std::string> stop_of(double stiffness) {
  const std::vector<Finding> all =
      found(hidden("joint_stop", "a", {{"stiffness", stiffness}, {"position", 0.15}}),
            {"joint_stop", "cable_spring", "tether"});
  if (all.size() != 1U) return {};
  return all.front().one_of;
}

/// A cord to the room pulls from one angle on, as a stop pushes, and lets the joint go on.
TEST(Set, AStopThatYieldsMayBeACord) {
  const std::vector<std::string> hard = stop_of(200.0), soft = stop_of(1.0);
  EXPECT_EQ(hard, std::vector<std::string>{"joint_stop"});
  EXPECT_EQ(soft, (std::vector<std::string>{"joint_stop", "tether", "cable_spring"}));
}

}  // namespace
}  // namespace sanso::diagnose
