// Laws of the grades, and of the paragraph that a person reads first.
#include "tools/diagnose/verdict/outlook.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/verdict/conclude.h"
#include "tools/diagnose/verdict/plain_words.h"

namespace sanso::diagnose {
namespace {

constexpr double kNominal = 0.1, kBaseline = 0.06, kNoise = 0.001;

Outlook of(double named, double patched, double baseline = kBaseline,
           const RemainsSettings& remains = {}) {
  HeldoutScores scores;
  scores[Horizon::ahead(0.5)].all = FitScore{kNominal, patched, kNoise, baseline, named};
  return *outlook(scores, "rad", remains, DecisionSettings{});
}

TEST(Outlook, AGradeNeverGetsWorseWhileTheNamesLeaveLess) {
  Grade last = Grade::located;
  for (double named = kNominal; named > 0.5 * kNoise; named *= 0.93) {
    const Outlook o = of(named, named);
    EXPECT_LE(static_cast<int>(o.grade), static_cast<int>(last)) << named;
    last = o.grade;
  }
  EXPECT_EQ(last, Grade::explained);
}

TEST(Outlook, NamesThatDoNoBetterThanGoingOnExplainAPartAtMost) {
  for (const double share : {1.0, 0.9, 0.5}) {
    const double named = 0.02;
    EXPECT_EQ(of(named, named, share * named).grade, Grade::in_part) << share;
  }
  EXPECT_EQ(of(0.02, 0.02, 0.021).grade, Grade::mostly);
  EXPECT_EQ(of(0.02, 0.02, NAN).grade, Grade::mostly) << "nothing was there to beat";
}

TEST(Outlook, AModelWithoutACertainNameDescribesAndDoesNotExplain) {
  EXPECT_EQ(of(kNominal, 0.01).grade, Grade::described);
  EXPECT_EQ(of(NAN, 0.01).grade, Grade::described) << "nothing has a name";
  EXPECT_EQ(of(kNominal, 0.01, 0.005).grade, Grade::located) << "going on predicts better";
  EXPECT_EQ(of(kNominal, 0.08).grade, Grade::located);
  EXPECT_EQ(of(0.09, 0.01).grade, Grade::in_part) << "a name removes something";
}

TEST(Outlook, WhatIsLeftMattersAboveNoiseAndAboveWhatTheUserCanLiveWith) {
  EXPECT_FALSE(of(kNoise, 1.2 * kNoise).matters);
  EXPECT_TRUE(of(kNoise, 2.0 * kNoise).matters);
  RemainsSettings lenient;
  lenient.matters = 0.01;
  EXPECT_FALSE(of(kNoise, 0.009, kBaseline, lenient).matters);
  EXPECT_TRUE(of(kNoise, 0.011, kBaseline, lenient).matters);
  EXPECT_EQ(of(0.009, 0.009, kBaseline, lenient).grade, Grade::explained);
}

TEST(Outlook, SpeaksOfTheShortestScoredHorizonThatReachesTheUsers) {
  HeldoutScores scores;
  for (const double s : {0.1, 0.5, 2.0, 10.0})
    scores[Horizon::ahead(s)].all = FitScore{1.0, 1.0, 0.1};
  scores[Horizon::ahead(0.7)].channels["q:knee"] = {1.0, 1.0, 0.1};  // not scored as a whole
  const auto told = [&](double seconds) {
    RemainsSettings remains;
    remains.horizon = seconds;
    return outlook(scores, "rad", remains, DecisionSettings{})->horizon.text();
  };
  EXPECT_EQ(told(0.05), "0.1");
  EXPECT_EQ(told(0.5), "0.5");
  EXPECT_EQ(told(0.6), "2");
  EXPECT_EQ(told(5.0), "10");
  EXPECT_EQ(told(60.0), "10") << "none reaches: the longest";
  EXPECT_FALSE(outlook({}, "rad", RemainsSettings{}, DecisionSettings{}).has_value());
}

TEST(Horizon, IsWhatFilesCallItAndStandsInTheirOrder) {
  EXPECT_EQ(Horizon::ahead(0.50004), Horizon::ahead(0.5)) << "three digits";
  EXPECT_EQ(Horizon::ahead(2.0).text(), "2");
  EXPECT_EQ(Horizon::recorded_motion().text(), "0");
  EXPECT_FALSE(Horizon::recorded_motion().runs_ahead());
  EXPECT_TRUE(Horizon::ahead(0.01).runs_ahead());
  EXPECT_LT(Horizon::ahead(10.0), Horizon::ahead(2.0)) << "by text";
}

// ---- plain words

Finding finding(VerdictStatus status) {
  Finding f;
  f.effect = "coulomb_friction";
  f.where = {"knee"};
  f.one_of = {"coulomb_friction"};
  if (status == VerdictStatus::one_of) f.one_of.emplace_back("backlash");
  f.parameters["coulomb"] = {0.5, 0.49, 0.51, "N m", false};
  f.status = status;
  return f;
}

Evidence evidence(VerdictStatus status) {
  Evidence e;
  e.joints = {"hip", "knee"};
  e.findings = {finding(status)};
  e.proof.scores[Horizon::ahead(0.5)].all = FitScore{0.1, 0.002, kNoise, kBaseline, 0.002};
  e.proof.recordings = {"rec_3"};
  return e;
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(PlainWords, SayWhatWhereHowSureAndHowMuchBetter) {
  const std::string name(find_effect("coulomb_friction")->name);
  for (const VerdictStatus status :
       {VerdictStatus::confirmed, VerdictStatus::one_of, VerdictStatus::present_unnamed}) {
    const std::string text = conclude(evidence(status)).summary;
    for (const std::string& part :
         {name, std::string("knee"), std::string("0.1 to 0.002 rad"), std::string("0.06")})
      EXPECT_TRUE(holds(text, part)) << part << ": " << text;
    EXPECT_EQ(holds(text, ", confirmed"), status == VerdictStatus::confirmed) << text;
    EXPECT_EQ(holds(text, std::string(find_effect("backlash")->name)),
              status == VerdictStatus::one_of)
        << text;
    EXPECT_EQ(holds(text, "not confirmed"), status == VerdictStatus::present_unnamed) << text;
    EXPECT_FALSE(holds(text, "\n")) << "one paragraph";
  }
}

/// A limit of acceleration that is off stands at its end, however narrow its interval.
TEST(PlainWords, GiveTheSizeThatWasFittedAndNotTheOneThatStandsAtItsEnd) {
  Evidence e = evidence(VerdictStatus::confirmed);
  e.findings.front().parameters = {{"acceleration", {1e6, 9.9e5, 1e6, "rad/s^2", false}},
                                   {"speed", {1.43, 1.2, 1.6, "rad/s", false}}};
  const Verdict v = conclude(e);
  EXPECT_TRUE(holds(v.summary, "speed 1.43 rad/s")) << v.summary;
  EXPECT_TRUE(holds(v.answer, "speed 1.43 rad/s")) << v.answer;
}

TEST(PlainWords, SayWhatRecordingsDisagreeAboutAndNotesKeepIt) {
  Evidence e = evidence(VerdictStatus::confirmed);
  e.notes = {"a note of the gate"};
  e.disagreements = {"recordings disagree about a size"};
  const Verdict v = conclude(e);
  EXPECT_TRUE(holds(v.summary, " But recordings disagree about a size.")) << v.summary;
  EXPECT_FALSE(holds(v.summary, e.notes[0])) << v.summary;
  ASSERT_EQ(v.notes.size(), 3U) << "the last one is on what is left";
  EXPECT_EQ(v.notes[1], e.disagreements[0]);
}

TEST(PlainWords, OfNothingPromiseNothing) {
  Evidence e;
  e.joints = {"hip"};
  const std::string text = conclude(e).summary;
  EXPECT_TRUE(holds(text, "Nothing is missing")) << text;
  EXPECT_FALSE(holds(text, "Record next")) << text;
}

TEST(PlainWords, OfAnEndedRunSayAtWhatItWasEnded) {
  Evidence e = evidence(VerdictStatus::unfinished);
  e.unfinished = Unfinished{"what of the knee?", 12.0, 0.8};
  const Verdict v = conclude(e);
  EXPECT_EQ(v.status, VerdictStatus::unfinished);
  EXPECT_TRUE(v.mismatch);
  EXPECT_FALSE(v.outlook.has_value()) << "nothing was scored";
  for (const char* part : {"not finished", "12 s", "what of the knee?", "knee", "80 %"})
    EXPECT_TRUE(holds(v.summary, part)) << part << ": " << v.summary;
  e.findings.clear();
  EXPECT_FALSE(conclude(e).mismatch) << "nothing was found yet";
}

TEST(PlainWords, PutARecordingWhereOneCouldDecide) {
  Evidence e = evidence(VerdictStatus::one_of);
  e.next_experiment.emplace();
  e.next_experiment->what = "double the P gain";
  e.next_experiment->separates = {"coulomb_friction", "backlash"};
  EXPECT_TRUE(holds(conclude(e).summary, "Record next: double the P gain"));
  e.next_experiment.reset();
  e.proof.last_part = true;
  EXPECT_TRUE(holds(conclude(e).summary, "second condition"));
}

// A limit that the fit left off has the largest number of all, and says nothing.
TEST(PlainWords, ALimitThatIsOffIsNotItsSize) {
  Finding f;
  f.effect = "servo_profile";
  f.one_of = {f.effect};
  f.where = {"knee"};
  f.status = VerdictStatus::confirmed;
  f.parameters["speed"] = {999999.85, 999999.3, 1e6, "rad/s", false};
  f.parameters["acceleration"] = {12.0, 11.0, 13.0, "rad/s^2", false};
  EXPECT_EQ(sentence(f), "servo_profile at knee (acceleration 12 rad/s^2)");
}

}  // namespace
}  // namespace sanso::diagnose
