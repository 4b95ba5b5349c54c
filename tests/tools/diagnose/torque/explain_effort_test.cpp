// What was hidden in a small world is found in its effort, with its size; what was not is not.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "shared/files/input_error.h"
#include "tests/support/noisy_world.h"
#include "tools/diagnose/torque/judge.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr const char* kTorque =
    "actuator = \"torque\"\ntorque_limit = 0.0\nviscous = 0.05\n"
    "armature = 0.01\nposition_noise = 0.0001\n";

/// Twenty seconds of two sines at every joint, held against gravity by nobody: the world swings.
recording::Recording swing(const ModelFolder& world, double strength, std::uint64_t noise_seed) {
  const Drive drive = make_test_drive(world, 20.0, 0.004, [&](int j, double t) {
    return strength * (std::sin((2.1 + 1.3 * j) * t) + 0.6 * std::sin((5.3 + 0.9 * j) * t + j));
  });
  Recorded how;
  how.noise_seed = noise_seed;
  return record(world, drive, how);
}

EffortOutcome explained(const ModelFolder& model, const std::vector<recording::Recording>& data,
                        bool free_gain = false) {
  return explain_effort(effort_rows(model, data, free_gain, Settings{}), Settings{}, {});
}

std::vector<std::string> named(const EffortOutcome& outcome) {
  std::vector<std::string> out;
  for (const JudgedTerm& t : outcome.terms) {
    if (t.predicts) out.push_back(in_words(t.term));
  }
  return out;
}

const JudgedTerm* find(const EffortOutcome& outcome, const std::string& effect,
                       const std::string& where) {
  for (const JudgedTerm& t : outcome.terms) {
    if (t.predicts && t.term.effect == effect && t.term.where.front() == where) return &t;
  }
  return nullptr;
}

void expect_holds(const JudgedTerm* term, double truth, double at_most_wide) {
  ASSERT_NE(term, nullptr);
  const JudgedValue& v = term->values.front();
  // intervals are of 95 %, and a seed is one draw: half as wide again
  const double half = 0.5 * (v.high - v.low);
  EXPECT_NEAR(v.value, truth, 1.5 * half + 0.02 * std::abs(truth));
  EXPECT_LT(half, at_most_wide);
}

TEST(ExplainEffort, FindsFrictionAndRotorWhereTheyAre) {
  const ModelFolder model = two_links(kTorque);
  const EffortOutcome outcome =
      explained(model, {swing(hiding(model, {hidden("coulomb_friction", "a", {{"coulomb", 0.2}}),
                                             hidden("rotor_inertia", "b", {{"armature", 0.03}})}),
                              1.5, 11)});
  expect_holds(find(outcome, "coulomb_friction", "a"), 0.2, 0.05);
  expect_holds(find(outcome, "rotor_inertia", "b"), 0.03, 0.01);
  EXPECT_EQ(named(outcome).size(), 2u) << testing::PrintToString(named(outcome));
}

TEST(ExplainEffort, NamesNothingOnACleanWorldWithinTolerances) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    ModelFolder model = two_links(kTorque);
    ModelFolder world = hiding(model, {hidden("link_mass", "lower", {{"share", 0.02}}),
                                       hidden("rotor_inertia", "a", {{"armature", 0.0005}})});
    const EffortOutcome outcome = explained(model, {swing(world, 1.5, seed)});
    EXPECT_TRUE(named(outcome).empty()) << testing::PrintToString(named(outcome));
  }
}

TEST(ExplainEffort, FindsTheOrdersOfARippleOneByOne) {
  const ModelFolder model = pendulum(kTorque);
  const EffortOutcome outcome = explained(
      model, {swing(hiding(model, {hidden("cogging", "a",
                                          {{"sine", 0.06}, {"cosine", 0.0}, {"order", 7.0}})}),
                    0.6, 5)});
  const JudgedTerm* ripple = find(outcome, "cogging", "a");
  ASSERT_NE(ripple, nullptr) << testing::PrintToString(named(outcome));
  EXPECT_EQ(ripple->term.fixed.at("order"), 7.0);
  EXPECT_NEAR(ripple->values[0].value, 0.06, 0.01);
  EXPECT_NEAR(ripple->values[1].value, 0.0, 0.01);
}

TEST(ExplainEffort, GivesNoNegativeFriction) {
  // less viscous friction than the model states, and no more can be taken away than there is
  ModelFolder world = pendulum(kTorque);
  world.joints.front().viscous = 0.0;
  const EffortOutcome outcome = explained(pendulum(kTorque), {swing(world, 0.6, 3)});
  for (const JudgedTerm& t : outcome.terms) {
    if (t.term.effect == "coulomb_friction" || t.term.effect == "air_drag") {
      EXPECT_GE(t.values.front().value, 0.0);
    }
    if (t.term.effect == "viscous_friction") {
      EXPECT_GE(t.values.front().value, -0.05);
    }
  }
  expect_holds(find(outcome, "viscous_friction", "a"), -0.05, 0.03);
}

TEST(ExplainEffort, FindsTheGainOfADriveThatNobodyStated) {
  const ModelFolder model = two_links(kTorque);
  recording::Recording r =
      swing(hiding(model, {hidden("coulomb_friction", "b", {{"coulomb", 0.15}})}), 1.5, 2);
  for (recording::Channel& c : r.channels) {
    if (c.name.starts_with("tau_cmd:"))
      for (double& x : c.values) x /= 0.25;  // 0.25 N m for one unit
  }
  const EffortOutcome outcome = explained(model, {r}, true);
  ASSERT_EQ(outcome.gains.size(), 2u);
  for (const EffortGainFound& g : outcome.gains) {
    EXPECT_TRUE(g.determined) << g.joint;
    EXPECT_NEAR(g.value, 0.25, 0.01) << g.joint;
  }
  expect_holds(find(outcome, "coulomb_friction", "b"), 0.15, 0.05);
}

TEST(ExplainEffort, AnEffortOfAnotherRunIsNotPredicted) {
  const ModelFolder model = pendulum(kTorque);
  recording::Recording r = swing(model, 0.6, 4);
  const auto effort = r.find("tau_cmd:a");
  std::vector<double> turned(effort.begin(), effort.end());
  std::rotate(turned.begin(), turned.begin() + static_cast<long>(turned.size() / 3), turned.end());
  r.set("tau_cmd:a", turned);
  const EffortOutcome outcome = explained(model, {r});
  ASSERT_EQ(outcome.scores.size(), 1u);
  const EffortScore& s = outcome.scores.front();
  EXPECT_GT(s.patched, 0.7 * s.constant) << testing::PrintToString(named(outcome));
}

TEST(EffortRows, SayWhatIsMissing) {
  const ModelFolder servo = pendulum("actuator = \"position_pd\"\nkp = 3\n");
  recording::Recording r = swing(pendulum(kTorque), 0.6, 4);
  std::erase_if(r.channels, [](const auto& c) { return c.name.starts_with("tau_cmd"); });
  EXPECT_THROW(effort_rows(servo, {r}, false, Settings{}), files::InputError);
}

}  // namespace
}  // namespace sanso::diagnose
