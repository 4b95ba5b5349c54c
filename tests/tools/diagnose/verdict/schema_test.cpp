// verdict.json has exactly the keys that scripts rely on, whatever the verdict holds.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "tools/diagnose/verdict/verdict.h"

namespace sanso::diagnose {
namespace {

using nlohmann::json;
using Keys = std::set<std::string>;

Keys keys(const json& object) {
  Keys out;
  for (const auto& [key, value] : object.items()) out.insert(key);
  return out;
}

/// A verdict that holds one of everything.
Verdict full() {
  Verdict v;
  Finding f;
  f.effect = "backlash";
  f.parameters["width"] = {0.021, 0.019, 0.023, "rad", false};
  f.rivals.push_back({"joint_compliance", {"knee"}, 0.5, 1.0, 0.9, ""});
  f.incidence.push_back({{Signal::q, "reversal"}, 20.0, 1.0, 0.9, 1.1});
  v.findings.push_back(f);
  v.heldout[Horizon::ahead(0.5)].all = FitScore{0.031, 0.006, 0.005};
  v.heldout[Horizon::ahead(0.5)].channels["q:knee"] = {0.031, 0.006, 0.005};
  v.locations.push_back({"knee", "reversal", 0.62, 9.1});
  v.refused.push_back({"a.csv", "pwm:knee", 812, "16-bit wrap", "jump"});
  v.untestable.push_back({"battery_drift", "no voltage"});
  v.detectable.push_back({"backlash", "hip", "width", "rad", 0.002});
  v.next_experiment.emplace();
  v.unexplained.emplace();
  v.unfinished.emplace();
  v.outlook.emplace();
  v.stretches.push_back({"a.csv", "hip", 1.0, 1.5, 9.0});
  v.notes = {"note"};
  v.data_hash = {{"a.csv", "00ff"}};
  return v;
}

TEST(Schema, TheTopHasTheseKeysAndNoOther) {
  const Keys expected{"mismatch",   "status",          "answer",      "summary",   "outlook",
                      "unfinished", "findings",        "locations",   "fit",       "refused",
                      "untestable", "detectable",      "unexplained", "stretches", "notes",
                      "data_hash",  "next_experiment", "seed"};
  for (const Verdict& v : {Verdict{}, full()})
    EXPECT_EQ(keys(json::parse(verdict_json(v))), expected);
}

TEST(Schema, EveryPartHasItsKeysAndNoOther) {
  const json v = json::parse(verdict_json(full()));
  const json& f = v.at("findings").at(0);
  EXPECT_EQ(keys(f), (Keys{"effect", "family", "where", "regime", "status", "reserve", "parameters",
                           "evidence", "one_of", "rivals", "incidence"}));
  EXPECT_EQ(keys(f.at("parameters").at("width")),
            (Keys{"value", "unit", "low", "high", "at_bound"}));
  EXPECT_EQ(keys(f.at("evidence")),
            (Keys{"p_family", "heldout_gain", "heldout_gain_se", "heldout_gain_low"}));
  EXPECT_EQ(keys(f.at("rivals").at(0)),
            (Keys{"effect", "where", "heldout_gain", "behind_in_se", "similarity", "refuted_by"}));
  EXPECT_EQ(keys(f.at("incidence").at(0)), (Keys{"residual", "predicted", "slope", "low", "high"}));
  EXPECT_EQ(keys(v.at("locations").at(0)),
            (Keys{"where", "regime", "share", "lift", "mean", "q_value"}));
  EXPECT_EQ(keys(v.at("refused").at(0)), (Keys{"file", "channel", "row", "defect", "message"}));
  EXPECT_EQ(keys(v.at("untestable").at(0)), (Keys{"effect", "because"}));
  EXPECT_EQ(keys(v.at("detectable").at(0)), (Keys{"effect", "where", "parameter", "size", "unit"}));
  EXPECT_EQ(keys(v.at("next_experiment")), (Keys{"what", "kind", "separates", "nats_per_second",
                                                 "seconds_to_100_to_1", "motion_file"}));
  EXPECT_EQ(keys(v.at("unexplained")), (Keys{"channel", "predictable", "p", "energy_share", "where",
                                             "regime", "formula", "nearest_effect"}));
  EXPECT_EQ(keys(v.at("unfinished")), (Keys{"asking", "seconds", "removed"}));
  EXPECT_EQ(keys(v.at("outlook")),
            (Keys{"grade", "horizon", "unit", "nominal", "baseline", "named", "left", "noise",
                  "named_share", "patched_share", "matters_from", "matters"}));
}

TEST(Schema, ScoresStandByHorizonAndChannel) {
  const json fit = json::parse(verdict_json(full())).at("fit");
  EXPECT_EQ(keys(fit), (Keys{"heldout", "recordings"}));
  const json& half = fit.at("heldout").at("0.5s");
  EXPECT_EQ(keys(half),
            (Keys{"nominal", "baseline", "named", "patched", "noise", "explained", "channels"}));
  EXPECT_EQ(keys(half.at("channels")), Keys{"q:knee"});
  EXPECT_EQ(keys(half.at("channels").at("q:knee")),
            (Keys{"nominal", "baseline", "named", "patched", "noise", "explained"}));
}

TEST(Schema, WhatIsNotThereIsNullAndLists) {
  const json v = json::parse(verdict_json(Verdict{}));
  EXPECT_TRUE(v.at("next_experiment").is_null());
  EXPECT_TRUE(v.at("unexplained").is_null());
  for (const char* list :
       {"findings", "locations", "refused", "untestable", "detectable", "stretches", "notes"})
    EXPECT_TRUE(v.at(list).is_array()) << list;
  EXPECT_TRUE(v.at("data_hash").is_object());
}

TEST(Schema, NoNumberThatJsonCannotHoldGetsOut) {
  for (const double bad : {static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    Verdict v = full();
    v.findings[0].p_family = v.findings[0].heldout_gain = bad;
    v.findings[0].parameters["width"] = {bad, bad, bad, "rad", false};
    v.findings[0].rivals[0].behind_in_se = bad;
    v.findings[0].incidence[0].slope = bad;
    v.heldout[Horizon::ahead(0.5)].all = FitScore{bad, bad, bad};
    v.detectable[0].size = bad;
    v.next_experiment->seconds_to_100_to_1 = bad;
    v.unexplained->predictable = bad;
    v.stretches[0].level = bad;
    const json parsed = json::parse(verdict_json(v));
    EXPECT_TRUE(parsed.at("findings").at(0).at("evidence").at("p_family").is_null());
    EXPECT_TRUE(parsed.at("findings").at(0).at("parameters").at("width").at("low").is_null());
    EXPECT_TRUE(parsed.at("next_experiment").at("seconds_to_100_to_1").is_null());
  }
}

TEST(Schema, TextNeedsNoCareOfTheWriter) {
  Verdict v;
  v.answer = "a \"quoted\" word, a \\ and a line\nbreak";
  v.notes = {"µ, 関節"};
  const json parsed = json::parse(verdict_json(v));
  EXPECT_EQ(parsed.at("answer"), v.answer);
  EXPECT_EQ(parsed.at("notes").at(0), v.notes[0]);
}

}  // namespace
}  // namespace sanso::diagnose
