// Momentum and free fall of one body: what falls, bounces and slips by textbook formulas is
// recovered with its interval, and nothing is found where nothing is hidden.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/tools/diagnose/wholebody/made_toss.h"

namespace sanso::diagnose {
namespace {

using namespace test;

WholeDiagnosis of_tosses(const World& world, const std::string& ground) {
  std::vector<recording::Recording> tosses;
  for (unsigned long seed = 1; seed <= 16; ++seed) tosses.push_back(toss(world, seed));
  return diagnosed(body_of(ground, kBall), tosses);
}

constexpr const char* kTrue = "[ground]\nfriction = 0.2\nrestitution = 0.4\nheight = 0.0\n";

TEST(FreeBody, NothingIsMissingWhereTheModelIsTheWorld) {
  const Verdict v = of_tosses({}, kTrue).verdict;
  EXPECT_EQ(v.status, VerdictStatus::absent) << told(v);
  EXPECT_GT(v.detectable.size(), 2U);
}

TEST(FreeBody, RestitutionAndFrictionAreFoundWithTheirIntervals) {
  const WholeDiagnosis d =
      of_tosses({}, "[ground]\nfriction = 0.6\nrestitution = 0.0\nheight = 0.0\n");
  const Finding* e = find(d.verdict, "restitution");
  const Finding* mu = find(d.verdict, "contact_friction");
  ASSERT_NE(e, nullptr) << told(d.verdict);
  ASSERT_NE(mu, nullptr) << told(d.verdict);
  EXPECT_NEAR(e->parameters.at("e").value, 0.4, 0.02);
  EXPECT_NEAR(mu->parameters.at("mu").value, 0.2, 0.02);
  EXPECT_EQ(find(d.verdict, "pose_scale"), nullptr);
  // what was found is in the model that is written, and the next diagnosis finds nothing
  ASSERT_TRUE(d.patched);
  const WholeBody again = parse_whole_body(whole_body_toml(*d.patched), kBall, "again");
  EXPECT_NEAR(*again.ground.restitution, 0.4, 0.02);
}

TEST(FreeBody, AScaleOfThePositionsIsToldFromAClock) {
  const Verdict lengths = of_tosses({.scale = 0.96}, kTrue).verdict;
  const Finding* scale = find(lengths, "pose_scale");
  ASSERT_NE(scale, nullptr) << told(lengths);
  EXPECT_TRUE(holds(scale->parameters.at("scale"), 0.96)) << told(lengths);
  EXPECT_EQ(scale->status, VerdictStatus::confirmed);
  EXPECT_EQ(lengths.findings.size(), 1U) << told(lengths);

  // a clock that runs 2 % slow makes it fall by as much too fast, and lie where it should
  const Verdict clock = of_tosses({.clock = 0.98}, kTrue).verdict;
  EXPECT_EQ(find(clock, "pose_scale"), nullptr) << told(clock);
  const Finding* other = find(clock, "gravity");
  ASSERT_NE(other, nullptr) << told(clock);
  EXPECT_EQ(other->status, VerdictStatus::one_of);
}

TEST(FreeBody, WithoutAGroundOfKnownHeightTheNamesStayASet) {
  const Verdict v = of_tosses({.scale = 0.96}, "").verdict;
  const Finding* scale = find(v, "pose_scale");
  ASSERT_NE(scale, nullptr) << told(v);
  EXPECT_EQ(scale->status, VerdictStatus::one_of);
}

TEST(FreeBody, WhatNobodyStatesIsEstimatedAndNotMissing) {
  const WholeDiagnosis d = of_tosses({}, "[ground]\nheight = 0.0\n");
  EXPECT_EQ(d.verdict.status, VerdictStatus::absent) << told(d.verdict);
  ASSERT_TRUE(d.patched && d.patched->ground.restitution);
  EXPECT_NEAR(*d.patched->ground.restitution, 0.4, 0.02);
}

TEST(FreeBody, FrictionOfWhatNeverSlipsIsUntestable) {
  const Verdict v = of_tosses({.friction = 20.0}, kTrue).verdict;
  EXPECT_EQ(find(v, "contact_friction"), nullptr) << told(v);
  EXPECT_TRUE(std::any_of(v.untestable.begin(), v.untestable.end(),
                          [](const Untestable& u) { return u.effect == "contact_friction"; }));
}

}  // namespace
}  // namespace sanso::diagnose
