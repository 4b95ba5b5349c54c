// Forces of the feet against weight and momentum: a known payload is weighed, bobbing weighs
// nothing, and a sum of forces names no link for certain.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/tools/diagnose/wholebody/made_body.h"

namespace sanso::diagnose {
namespace {

using namespace test;

constexpr double kG = 9.81, kMassOfAll = 5.0, kMassOfTrunk = 4.0;

/// Feet stay, the trunk goes up and down; `more` kg sit on the trunk. `lean`: of the attitude that
/// is recorded, rad about y.
recording::Recording bobbing(double more, double sensors, double lean, unsigned long seed) {
  recording::Recording r;
  r.file = "bob_" + std::to_string(seed) + ".csv";
  Random random(seed);
  const double w = 2.0 * std::numbers::pi * (0.8 + 0.1 * random.uniform()), depth = 0.03;
  std::vector<double> height, leg, force;
  for (double t = 0.0; t < 12.0; t += 0.01) {
    r.t.push_back(t);
    const double z = depth * std::sin(w * t);
    height.push_back(0.31 + z + 1e-5 * random.normal()), leg.push_back(-z);
    const double total =
        (kMassOfAll + more) * kG - (kMassOfTrunk + more) * depth * w * w * std::sin(w * t);
    force.push_back(0.5 * sensors * total + 0.2 * random.normal());
  }
  put(r, "q", "lr", [&](auto k, auto) { return leg[k]; });
  put(r, "base_p", "xyz", [&](auto k, auto i) { return i == 2 ? height[k] : 0.0; });
  put(r, "base_q", "wxyz", [&](auto, auto i) {
    return i == 0 ? std::cos(0.5 * lean) : i == 2 ? std::sin(0.5 * lean) : 0.0;
  });
  r.set("fz:l_foot", force), r.set("fz:r_foot", force);
  return r;
}

Verdict of(double more, double sensors = 1.0, double lean = 0.0, const std::string& toml = "") {
  return diagnosed(body_of(toml, kTwoLegs),
                   {bobbing(more, sensors, lean, 1), bobbing(more, sensors, lean, 2)})
      .verdict;
}

bool untestable(const Verdict& v, const std::string& effect) {
  return std::any_of(v.untestable.begin(), v.untestable.end(),
                     [&](const Untestable& u) { return u.effect == effect; });
}

TEST(Weight, BobbingWeighsNothing) {
  const Verdict v = of(0.0);
  EXPECT_EQ(v.status, VerdictStatus::absent) << told(v);
  EXPECT_TRUE(untestable(v, "contact_friction")) << "no foot slipped";
}

TEST(Weight, AKnownPayloadIsWeighedAndItsPlaceLeftOpen) {
  const Verdict v = of(0.8);
  const Finding* f = find(v, "link_mass");
  ASSERT_NE(f, nullptr) << told(v);
  EXPECT_NEAR(f->parameters.at("share").value * kMassOfTrunk, 0.8, 0.02);
  EXPECT_EQ(f->status, VerdictStatus::one_of);
  EXPECT_NE(std::find(f->one_of.begin(), f->one_of.end(), "payload"), f->one_of.end());
}

TEST(Weight, WhatTheModelSaysAlreadyIsNotFoundAgain) {
  const std::string payload = "[[effect]]\nid = \"payload\"\nwhere = [\"trunk\"]\nmass = 0.8\n";
  EXPECT_EQ(of(0.8, 1.0, 0.0, payload).status, VerdictStatus::absent);
  const std::string scale = "[[effect]]\nid = \"foot_force_scale\"\nscale = 1.2\n";
  EXPECT_EQ(of(0.0, 1.2, 0.0, scale).status, VerdictStatus::absent);
}

TEST(Weight, WithinTheToleranceOfAMassNothingIsMissing) {
  const Verdict v = of(0.05);
  EXPECT_EQ(v.status, VerdictStatus::absent) << told(v);
}

TEST(Soles, ALeaningVerticalShowsUnderStandingSoles) {
  const Verdict v = of(0.0, 1.0, 0.05);
  const Finding* f = find(v, "ground_slope");
  ASSERT_NE(f, nullptr) << told(v);
  EXPECT_NEAR(std::abs(f->parameters.at("y").value), 0.05, 0.002);
  EXPECT_EQ(f->status, VerdictStatus::one_of);
}

}  // namespace
}  // namespace sanso::diagnose
