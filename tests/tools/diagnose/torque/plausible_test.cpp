// What the choice of terms may not say, and what does not judge it: limits, ripples larger than the
// friction, enormous links, single blocks, motion that nobody fitted.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/tools/diagnose/torque/explained_effort.h"
#include "tools/diagnose/torque/judge.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// A start at full speed: one block holds more squares than all others together.
TEST(EffortGain, OneBlockDoesNotDecide) {
  const Settings settings;
  std::vector<double> a(60, 1.0), b(60, 0.6);
  const BlockCounts all(60, 1.0);
  EXPECT_GT(gain_of(a, b, all, settings, 1).low, 0.0);
  a[7] = 1000.0, b[7] = 1010.0;  // worse there, by more than all others gain
  EXPECT_GT(gain_of(a, b, all, settings, 1).low, 0.0);
  for (std::size_t k = 0; k < b.size(); ++k) b[k] = k % 2 == 0 ? 0.8 : 1.3;
  b[7] = 500.0;  // better there alone
  EXPECT_LE(gain_of(a, b, all, settings, 1).low, 0.0);
  EXPECT_LE(gain_of(a, a, all, settings, 1).low, 0.0) << "no change is no gain";
}

TEST(ChooseTerms, BuildsOnNoTermThatALimitStops) {
  // recorded is half of what is needed: a scale below its limit of 0.6
  const EffortRows rows = two_link_rows(nothing);
  EffortRows half = rows;
  for (EffortRow& row : half.rows) row.effort *= 0.5;
  const EffortOutcome outcome = explained(half, {"torque_constant"});
  EXPECT_TRUE(outcome.terms.empty()) << testing::PrintToString(outcome.log);
  EffortRows less = rows;
  for (EffortRow& row : less.rows) row.effort *= 0.8;
  EXPECT_EQ(named(explained(less, {"torque_constant"})),
            (Names{"torque_constant at a", "torque_constant at b"}));
}

/// Friction takes energy at every angle: a ripple larger than the dry friction is no friction. In
/// one direction of motion nothing else tells the two apart.
TEST(ChooseTerms, ARippleLargerThanTheFrictionIsCogging) {
  const Angle onward = [](int j, double t) { return j == 0 ? 0.9 * t : sines(1, t); };
  const auto rippled = [&](double friction, double ripple) {
    return explained(rows_of({recorded(test::two_links(kTorque), "one.csv", 30.0, onward)},
                             [=](const MotionSample& m, int j, double) {
                               return j == 0 ? friction + ripple * std::sin(5 * m.q[0]) : 0.0;
                             }),
                     {"coulomb_friction", "cogging", "position_friction"});
  };
  const auto ripple_of = [](const EffortOutcome& outcome) {
    Names out;
    for (const JudgedTerm& t : outcome.terms) {
      if (t.term.fixed.count("order") == 0) continue;
      out = t.equally_good;
      out.push_back(t.term.effect);
    }
    std::sort(out.begin(), out.end());
    return out;
  };
  EXPECT_EQ(ripple_of(rippled(0.1, 0.2)), Names{"cogging"});
  EXPECT_EQ(ripple_of(rippled(0.3, 0.1)), (Names{"cogging", "position_friction"}));
}

TEST(ChooseTerms, ARotorIsNamedBeforeAnEnormousLink) {
  const EffortOutcome outcome = explained(two_link_rows([](const MotionSample& m, int j, double) {
                                            return j == 0 ? 6.0 * m.ddq[0] : 0.0;
                                          }),
                                          {"rotor_inertia", "link_mass", "link_inertia"});
  ASSERT_FALSE(outcome.terms.empty());
  EXPECT_EQ(in_words(outcome.terms.front().term), "rotor_inertia at a");
}

TEST(Judge, WindowsFasterThanAnythingFittedDoNotJudge) {
  // the last tenth moves ten times as far
  const Angle burst = [](int j, double t) { return (t > 18.0 ? 10.0 : 1.0) * sines(j, t); };
  const EffortRows rows =
      rows_of({recorded(test::two_links(kTorque), "one.csv", 20.0, burst)},
              [](const MotionSample& m, int j, double part) {
                return friction_at_a(m, j, part) + (part > 0.9 && j == 0 ? 5.0 : 0.0);
              });
  const EffortOutcome outcome = explained(rows);
  const EffortScore& a = outcome.scores.front();
  EXPECT_GT(a.beyond, 50);
  EXPECT_LT(a.patched, a.nominal) << "what nobody saw decides nothing";
  EXPECT_EQ(explained(two_link_rows(friction_at_a)).scores.front().beyond, 0);
}

}  // namespace
}  // namespace sanso::diagnose
