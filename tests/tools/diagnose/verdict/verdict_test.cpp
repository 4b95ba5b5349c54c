// verdict.json: the keys that scripts rely on, and numbers that JSON can hold.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/verdict/verdict.h"

namespace sanso::diagnose {
namespace {

TEST(Verdict, HasTheDocumentedKeysAndParses) {
  Verdict v;
  v.mismatch = true;
  v.status = VerdictStatus::one_of;
  Finding f;
  f.effect = "backlash";
  f.where = {"l_knee"};
  f.one_of = {"backlash", "joint_compliance"};
  f.parameters["width"] = {0.021, 0.019, 0.023, "rad"};
  v.findings.push_back(f);
  v.heldout[Horizon::ahead(0.5)].all = FitScore{0.031, 0.006, 0.005};
  v.locations.push_back({"l_knee", "reversal", 0.62, 9.1});
  v.refused.push_back({"rec_2.csv", "pwm:knee", 812, "16-bit wrap", "jump"});
  const auto json = nlohmann::json::parse(verdict_json(v));
  EXPECT_EQ(json.at("status"), "ONE_OF");
  EXPECT_EQ(json.at("findings").at(0).at("parameters").at("width").at("value"), 0.021);
  EXPECT_EQ(json.at("findings").at(0).at("one_of").size(), 2U);
  EXPECT_NEAR(json.at("fit").at("heldout").at("0.5s").at("explained").get<double>(),
              (0.031 * 0.031 - 0.006 * 0.006) / (0.031 * 0.031 - 0.005 * 0.005), 1e-9);
  EXPECT_EQ(json.at("locations").at(0).at("regime"), "reversal");
  EXPECT_EQ(json.at("refused").at(0).at("row"), 812);
  EXPECT_TRUE(json.contains("next_experiment"));
  EXPECT_TRUE(json.contains("unexplained"));
  EXPECT_TRUE(json.contains("untestable"));
}

TEST(Finding, WhatEndsAtABoundIsNeverConfirmed) {
  Finding f;
  f.effect = "command_delay";
  f.one_of = {"command_delay"};
  f.parameters["delay"] = {0.02, 0.019, 0.021, "s", false};
  EXPECT_EQ(status_of(f), VerdictStatus::confirmed);
  f.parameters["delay"] = {0.06, 0.06, 0.06, "s", true};
  EXPECT_EQ(status_of(f), VerdictStatus::present_unnamed);
  EXPECT_NE(stopped_at_bounds(f).find("delay"), std::string::npos);
  f.one_of.emplace_back("sensor_delay");
  EXPECT_EQ(status_of(f), VerdictStatus::one_of);
  f.terms = {"cogging"};  // a spring and a ripple at one joint
  EXPECT_EQ(status_of(f), VerdictStatus::present_unnamed);
  EXPECT_NE(reserve(f).find("cogging"), std::string::npos);
  f.terms_of = kOfAngle;
  EXPECT_NE(reserve(f).find("of the angle"), std::string::npos);
  f.terms_of = kOfAcceleration;  // two inertias
  EXPECT_NE(reserve(f).find("an inertia"), std::string::npos);
}

TEST(Finding, WhatMayBeNothingIsNotConfirmed) {
  Finding f;
  f.effect = "supply_sag";
  f.one_of = {"supply_sag", "battery_drift"};
  EXPECT_EQ(status_of(f), VerdictStatus::one_of);
  f.spans_null = true;
  EXPECT_EQ(status_of(f), VerdictStatus::present_unnamed);
  EXPECT_NE(reserve(f).find("null"), std::string::npos);
}

TEST(Verdict, NaNBecomesNull) {
  Verdict v;
  v.locations.push_back({"a", "b", NAN, INFINITY});
  const auto json = nlohmann::json::parse(verdict_json(v));
  EXPECT_TRUE(json.at("locations").at(0).at("share").is_null());
}

TEST(FitScore, ExplainedIsOneAtTheNoiseAndZeroWithoutImprovement) {
  EXPECT_NEAR((FitScore{0.1, 0.01, 0.01}).explained(), 1.0, 1e-12);
  EXPECT_NEAR((FitScore{0.1, 0.1, 0.01}).explained(), 0.0, 1e-12);
  EXPECT_EQ((FitScore{0.01, 0.01, 0.02}).explained(), 0.0);  // nothing to explain
}

}  // namespace
}  // namespace sanso::diagnose
