// A table of evidence and the verdict that has to follow from it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/verdict/conclude.h"

namespace sanso::diagnose {
namespace {

/// What a search of clean data leaves: noise, and nothing found.
Evidence nothing_found() {
  Evidence e;
  e.joints = {"hip", "knee"};
  e.before.cells.push_back({"knee", "reversal", 0.6, 3.0, 0.1, 0.001, 100});
  e.left.level = 1.0;
  e.left.torque = {{0, 0.0, 0.8, 0.02, 0.02}, {1, 0.01, 0.5, 0.02, 0.02}};
  e.search.nearest_effect = "backlash";
  return e;
}

Finding finding(VerdictStatus status, std::vector<std::string> one_of = {"backlash"}) {
  Finding f;
  f.effect = "backlash";
  f.where = {"knee"};
  f.one_of = std::move(one_of);
  f.parameters["width"] = {0.021, 0.019, 0.023, "rad", false};
  f.status = status;
  return f;
}

Evidence found(VerdictStatus status, std::vector<std::string> one_of = {"backlash"}) {
  Evidence e = nothing_found();
  e.search.detected = true;
  e.findings = {finding(status, std::move(one_of))};
  return e;
}

/// Torque at the knee that its state predicts, far above noise.
Evidence with_predictable_torque(Evidence e) {
  e.left.torque[1] = {1, 0.6, 0.005, 0.1, 0.02};
  return e;
}

struct Row {
  const char* what;
  Evidence evidence;
  VerdictStatus status;
};

std::vector<Row> without_findings() {
  std::vector<Row> rows{{"clean data", nothing_found(), VerdictStatus::absent}};
  Evidence e = nothing_found();
  e.left.level = 3.0;
  rows.push_back({"a large error that nothing stood out in", e, VerdictStatus::absent});
  e.search.detected = true;
  rows.push_back({"a large error that is no noise", e, VerdictStatus::present_unnamed});
  e.left.level = 1.0;
  rows.push_back({"detected, and then explained by nuisances", e, VerdictStatus::absent});
  rows.push_back({"torque that the state predicts", with_predictable_torque(nothing_found()),
                  VerdictStatus::present_unnamed});
  e = nothing_found();
  e.left.stretches = {{"a.csv", "hip", 1.0, 1.5, 9.0}};
  rows.push_back({"stretches that do not matter", e, VerdictStatus::absent});
  e.left.stretches_matter = true, e.left.stretches_joint = 0;
  rows.push_back({"stretches that repeat", e, VerdictStatus::present_unnamed});
  e = nothing_found();
  e.search.refuted = {"backlash at knee (duty)"};
  rows.push_back({"a gain whose only name is refuted", e, VerdictStatus::present_unnamed});
  e = nothing_found();
  e.search.described = {"backlash at knee (duty)"};
  rows.push_back({"a description", e, VerdictStatus::present_unnamed});
  e = nothing_found();
  e.defects = {{"a.csv", "q:hip", 7, defect::kStuck, "it hangs"}};
  rows.push_back({"data that are refused", e, VerdictStatus::refused});
  return rows;
}

std::vector<Row> with_findings() {
  std::vector<Row> rows{
      {"one confirmed name", found(VerdictStatus::confirmed), VerdictStatus::confirmed},
      {"one of two names", found(VerdictStatus::one_of, {"backlash", "joint_compliance"}),
       VerdictStatus::one_of},
      {"a name with a reserve", found(VerdictStatus::present_unnamed),
       VerdictStatus::present_unnamed},
      {"a name, and torque beside it", with_predictable_torque(found(VerdictStatus::confirmed)),
       VerdictStatus::present_unnamed}};
  Evidence e = found(VerdictStatus::confirmed);
  e.findings.push_back(finding(VerdictStatus::one_of, {"backlash", "joint_compliance"}));
  rows.push_back({"one is confirmed, one of a set", e, VerdictStatus::one_of});
  e.findings.push_back(finding(VerdictStatus::present_unnamed));
  rows.push_back({"and one has a reserve", e, VerdictStatus::present_unnamed});
  e = found(VerdictStatus::confirmed);
  e.search.refuted = {"coulomb_friction at hip (velocity)"};
  rows.push_back({"what was refuted beside a finding", e, VerdictStatus::confirmed});
  e.left.level = 2.0;
  rows.push_back({"a name that leaves more than noise", e, VerdictStatus::present_unnamed});
  e = found(VerdictStatus::confirmed);
  e.defects = {{"a.csv", "", -1, defect::kEmpty, "0 bytes"}};
  rows.push_back({"a finding in data that are refused", e, VerdictStatus::refused});
  return rows;
}

TEST(Conclude, EveryEvidenceHasItsStatus) {
  for (const auto& rows : {without_findings(), with_findings()}) {
    for (const Row& row : rows) EXPECT_EQ(conclude(row.evidence).status, row.status) << row.what;
  }
}

TEST(Conclude, AMismatchIsWhatIsThereAndNotRefused) {
  for (const auto& rows : {without_findings(), with_findings()}) {
    for (const Row& row : rows) {
      const Verdict v = conclude(row.evidence);
      const bool there = v.status != VerdictStatus::absent && v.status != VerdictStatus::refused;
      EXPECT_EQ(v.mismatch, there) << row.what;
      EXPECT_EQ(v.unexplained.has_value(), v.status == VerdictStatus::present_unnamed) << row.what;
      EXPECT_FALSE(v.answer.empty()) << row.what;
    }
  }
}

TEST(Conclude, WhatLawsOfOneNameDifferByIsANoteAndNoFinding) {
  Evidence e = found(VerdictStatus::confirmed);
  e.findings[0].tolerated = true;
  const Verdict alone = conclude(e);
  EXPECT_EQ(alone.status, VerdictStatus::absent);
  EXPECT_FALSE(alone.mismatch);
  EXPECT_TRUE(alone.findings.empty());
  EXPECT_TRUE(std::any_of(alone.notes.begin(), alone.notes.end(), [](const std::string& note) {
    return note.starts_with("within tolerance: ") && note.find("backlash") != std::string::npos;
  }));
  e.findings.push_back(finding(VerdictStatus::one_of, {"backlash", "presliding_friction"}));
  EXPECT_EQ(conclude(e).status, VerdictStatus::one_of);
  EXPECT_EQ(conclude(e).findings.size(), 1U);
  EXPECT_EQ(conclude(with_predictable_torque(e)).status, VerdictStatus::present_unnamed)
      << "it covers nothing that is left";
}

TEST(Conclude, WhatMayBeNothingIsDescribedAndNamesNoCause) {
  Evidence e = found(VerdictStatus::confirmed);
  e.findings.push_back(finding(VerdictStatus::present_unnamed));
  e.findings[1].effect = "external_push";
  e.findings[1].spans_null = true;
  const Verdict v = conclude(e);
  ASSERT_EQ(v.findings.size(), 1U);
  EXPECT_EQ(v.findings[0].effect, "backlash");
  EXPECT_EQ(v.status, VerdictStatus::present_unnamed) << "predictions gain from something";
  EXPECT_NE(v.answer.find("Described, not explained, by external_push"), std::string::npos);
  e.findings[1].agreed_low = 0.8;  // recordings differ about its size, and agree that it is there
  EXPECT_EQ(conclude(e).findings.size(), 2U);
  e.findings[1].agreed_low = 0.0;
  e.findings[1].heldout_gain = 0.7;  // a stop that few shots touch: most of the error goes with it
  EXPECT_EQ(conclude(e).findings.size(), 2U);
  EXPECT_EQ(conclude(e).status, VerdictStatus::present_unnamed) << "its size is in doubt";
}

TEST(Conclude, OneFigureThatMayBeNothingIsNoMismatch) {
  Evidence e = found(VerdictStatus::present_unnamed);
  e.findings[0].spans_null = true;
  EXPECT_EQ(conclude(e).status, VerdictStatus::absent);
  EXPECT_NE(conclude(e).answer.find("Described, not explained, by backlash"), std::string::npos);
  Evidence left = e;
  left.left.level = 3.0;
  EXPECT_EQ(conclude(left).status, VerdictStatus::present_unnamed) << "more than noise is left";
  Evidence two = e;
  two.findings.push_back(e.findings[0]);
  EXPECT_EQ(conclude(two).status, VerdictStatus::present_unnamed) << "both may not be nothing";
  Evidence shape = e;
  shape.findings[0].parameters["loss"] = {0.1, -0.1, 0.3, "-", false};
  EXPECT_EQ(conclude(shape).status, VerdictStatus::present_unnamed) << "nor both figures of one";
}

TEST(Conclude, IsAFunctionOfTheEvidence) {
  for (const Row& row : with_findings()) {
    EXPECT_EQ(verdict_json(conclude(row.evidence)), verdict_json(conclude(row.evidence)));
  }
}

TEST(Conclude, ARefusalSaysFileChannelRowAndDefectAndNothingElse) {
  Evidence e = found(VerdictStatus::confirmed);
  e.defects = {{"a.csv", "q:hip", 7, defect::kStuck, "it hangs"},
               {"b.csv", "", -1, defect::kEmpty, "0 bytes"}};
  const Verdict v = conclude(e);
  for (const char* part : {"a.csv", "q:hip", "row 7", defect::kStuck, "it hangs"})
    EXPECT_NE(v.answer.find(part), std::string::npos) << part;
  EXPECT_EQ(v.refused.size(), 2u);
  EXPECT_TRUE(v.findings.empty());
  EXPECT_TRUE(v.locations.empty());
}

TEST(Conclude, TheAnswerNamesWhatItFoundAndWhere) {
  const Verdict one = conclude(found(VerdictStatus::confirmed));
  EXPECT_NE(one.answer.find("backlash at knee (width 0.021 rad)"), std::string::npos) << one.answer;
  const Verdict set = conclude(found(VerdictStatus::one_of, {"backlash", "joint_compliance"}));
  EXPECT_NE(set.answer.find("one of {backlash, joint_compliance} at knee"), std::string::npos);
  EXPECT_EQ(set.answer.find("0.021"), std::string::npos) << "no number of a name that may be wrong";
  Evidence everywhere = found(VerdictStatus::confirmed);
  everywhere.findings[0].where.clear();
  EXPECT_NE(conclude(everywhere).answer.find("at the whole robot"), std::string::npos);
}

TEST(Conclude, TheAnswerSaysWhatSpeaksAgainst) {
  Evidence e = nothing_found();
  e.search.refuted = {"backlash at knee (duty)"};
  EXPECT_NE(conclude(e).answer.find("Not backlash at knee (duty)"), std::string::npos);
  e.search.described = {"spring at hip (position)"};
  EXPECT_NE(conclude(e).answer.find("Described, not explained, by spring at hip (position)"),
            std::string::npos);
}

TEST(Conclude, TellsEverythingThatWasMeasured) {
  Evidence e = found(VerdictStatus::confirmed);
  e.proof.scores[Horizon::ahead(0.5)].all = FitScore{0.03, 0.006, 0.005};
  e.proof.recordings = {"rec_2"};
  e.untestable = {{"battery_drift", "no voltage"}};
  e.detectable = {{"backlash", "hip", "width", "rad", 0.002}};
  e.notes = {"a.csv: jitter"};
  e.data_hash = {{"a.csv", "00ff"}};
  e.seed = 17;
  const Verdict v = conclude(e);
  EXPECT_EQ(v.heldout.at(Horizon::ahead(0.5)).all->patched, 0.006);
  EXPECT_EQ(v.heldout_recordings, e.proof.recordings);
  EXPECT_EQ(v.untestable[0].effect, "battery_drift");
  EXPECT_EQ(v.detectable[0].size, 0.002);
  EXPECT_EQ(v.locations[0].where, "knee");
  EXPECT_EQ(v.data_hash, e.data_hash);
  EXPECT_EQ(v.seed, 17u);
  ASSERT_EQ(v.notes.size(), 2u);
  EXPECT_EQ(v.notes[0], "a.csv: jitter");
  EXPECT_NE(v.notes[1].find("noise levels"), std::string::npos);
}

TEST(Unexplained, IsAskedInTheOrderOfHowMuchItSays) {
  Evidence e = nothing_found();
  e.search.detected = true, e.left.level = 3.0;
  EXPECT_EQ(unexplained(e)->shows_in, ShowsIn::position);
  EXPECT_EQ(unexplained(e)->where, "knee") << "the strongest cell of the map";
  e.left.stretches = {{"a.csv", "hip", 1.0, 1.5, 9.0}};
  e.left.stretches_matter = true, e.left.stretches_joint = 0;
  EXPECT_EQ(unexplained(e)->shows_in, ShowsIn::stretches);
  EXPECT_EQ(unexplained(e)->where, "hip");
  e.left.velocity = {{0, 0.7, 0.005, 0.1, 0.02}};
  EXPECT_EQ(unexplained(e)->shows_in, ShowsIn::velocity_channel);
  e = with_predictable_torque(e);
  EXPECT_EQ(unexplained(e)->shows_in, ShowsIn::torque);
  EXPECT_EQ(unexplained(e)->where, "knee");
  EXPECT_EQ(unexplained(e)->predictable, 0.6);
  EXPECT_EQ(unexplained(e)->nearest_effect, "backlash");
}

TEST(MostPredictable, NeedsSignificanceAShareAndMoreThanNoise) {
  const Predictability good{0, 0.5, 0.005, 0.1, 0.02};
  const DecisionSettings decisions;
  ASSERT_NE(most_predictable({good}, decisions), nullptr);
  Predictability p = good;
  p.p = 0.05;
  EXPECT_EQ(most_predictable({p}, decisions), nullptr);
  p = good, p.explained = 0.05;
  EXPECT_EQ(most_predictable({p}, decisions), nullptr);
  p = good, p.torque_rms = 0.025;
  EXPECT_EQ(most_predictable({p}, decisions), nullptr);
  EXPECT_EQ(most_predictable({}, decisions), nullptr);
}

TEST(MostPredictable, IsTheOneThatIsExplainedBest) {
  const std::vector<Predictability> left{{0, 0.3, 0.005, 0.1, 0.02}, {1, 0.6, 0.005, 0.1, 0.02}};
  EXPECT_EQ(most_predictable(left, DecisionSettings{})->joint, 1);
}

TEST(LocationSentence, NamesTheCalledCellsOfTheFirstJointOnly) {
  LocationMap map;
  EXPECT_EQ(location_sentence(map), "spread evenly over joints and regimes");
  map.cells = {{"knee", "reversal", 0.5, 4.0, 0.0, 0.001, 50},
               {"hip", "rest", 0.2, 3.0, 0.0, 0.001, 50},
               {"knee", "high load", 0.2, 2.0, 0.0, 0.01, 50},
               {"knee", "fast", 0.2, 2.0, 0.0, 0.5, 50}};
  EXPECT_EQ(location_sentence(map), "knee: reversal, high load");
  map.cells[0].lift = 1.1;
  EXPECT_EQ(location_sentence(map).find("reversal"), std::string::npos) << "no lift, no place";
}

/// Of a law that is not in the library names take what they can. What they leave tells.
TEST(Conclude, BesideMuchThatStaysNoNameIsSure) {
  for (const std::vector<std::string>& set :
       {std::vector<std::string>{"backlash"}, {"backlash", "joint_compliance"}}) {
    const VerdictStatus sure = set.size() > 1 ? VerdictStatus::one_of : VerdictStatus::confirmed;
    Evidence e = found(sure, set);
    e.left.share = e.decisions.much_left + 0.01;
    e.left.level = e.decisions.adequate + 0.01;
    const Verdict doubted = conclude(e);
    EXPECT_EQ(doubted.findings[0].status, VerdictStatus::present_unnamed);
    EXPECT_EQ(doubted.findings[0].one_of, set) << "what it may be is told all the same";
    EXPECT_NE(doubted.answer.find("so much stays beside it"), std::string::npos) << doubted.answer;
    Evidence little = e, quiet = e;
    little.left.share = e.decisions.much_left;  // however loud what is left: most has a name
    quiet.left.level = e.decisions.adequate;    // of a small effect noise is a large share
    for (const Evidence& other : {little, quiet})
      EXPECT_EQ(conclude(other).findings[0].status, sure);
  }
}

/// What descriptions take of the error has no name any more than what stays; what is unsure for a
/// reason of its own keeps that reason.
TEST(Conclude, BesideMuchThatIsOnlyDescribedNoNameIsSure) {
  const double nominal = 0.1, patched = 0.01, noise = 0.001;
  const double energy = nominal * nominal - noise * noise;
  const auto concluded = [&](double described, VerdictStatus status) {
    Evidence e = found(status);
    e.findings[0].spans_null = status == VerdictStatus::present_unnamed;
    e.findings[0].agreed_low = 1.0;
    e.left.share = 0.0;
    e.left.level = e.decisions.adequate + 0.01;
    const double named = std::sqrt(patched * patched + described * energy);
    e.proof.scores[Horizon::ahead(0.5)].all = FitScore{nominal, patched, noise, NAN, named};
    return conclude(e);
  };
  const double much = DecisionSettings{}.much_left;
  using enum VerdictStatus;
  EXPECT_EQ(concluded(much - 0.01, confirmed).findings.at(0).status, confirmed);
  EXPECT_EQ(concluded(much + 0.01, confirmed).findings.at(0).status, present_unnamed);
  EXPECT_NE(concluded(much + 0.01, present_unnamed).answer.find("contains the null"),
            std::string::npos);
}

/// A third of all commands lost scatters as far as any error: a share of it says nothing.
TEST(Conclude, ChanceIsSureWhereItLeavesNoiseAlone) {
  Evidence e = found(VerdictStatus::confirmed, {"packet_loss"});
  e.findings[0].chance = true;
  e.left.share = 0.01;
  e.left.level = e.decisions.adequate + 0.01;
  const Verdict doubted = conclude(e);
  EXPECT_EQ(doubted.findings[0].status, VerdictStatus::present_unnamed);
  EXPECT_NE(doubted.answer.find("more than noise stays"), std::string::npos) << doubted.answer;
  e.findings[0].chance = false;
  EXPECT_EQ(conclude(e).findings[0].status, VerdictStatus::confirmed);
  e.findings[0].chance = true;
  e.left.level = e.decisions.adequate;
  EXPECT_EQ(conclude(e).findings[0].status, VerdictStatus::confirmed);
}

}  // namespace
}  // namespace sanso::diagnose
