// A number is worth what it keeps under other choices: intervals take them in, names that one of
// them does without are not confirmed, and each choice explains the same fall.
#include "tools/diagnose/wholebody/choices.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/tools/diagnose/wholebody/made_body.h"

namespace sanso::diagnose {
namespace {

using namespace test;

Measured number(double value, double sigma) {
  Measured m;
  m.value = value, m.sigma = sigma, m.low = value - 2.0 * sigma, m.high = value + 2.0 * sigma;
  m.before = std::abs(value), m.gain = 0.9, m.gain_low = 0.5, m.groups = 12;
  return m;
}

Asked rebound() {
  return {"restitution", "contact", {"ball"}, "e", "-", "touchdown", 0.0, 0.05, {}, "rebound"};
}

WholeAnswers of(double value, double sigma) {
  return answer_to(rebound(), number(value, sigma), {});
}

TEST(Widen, TheIntervalTakesInWhatAnotherChoiceSays) {
  WholeAnswers answers = of(0.23, 0.009);
  ASSERT_EQ(answers.findings.size(), 1U);
  EXPECT_EQ(answers.findings[0].status, VerdictStatus::confirmed);
  answers.widen("pose_scale left out", of(0.168, 0.012), {});
  const VerdictParameter& e = answers.findings[0].parameters.at("e");
  EXPECT_DOUBLE_EQ(e.low, 0.168 - 0.024);
  EXPECT_DOUBLE_EQ(e.high, 0.23 + 0.018);
  EXPECT_DOUBLE_EQ(e.value, 0.23);
  EXPECT_EQ(answers.findings[0].status, VerdictStatus::confirmed) << "it is missing either way";
  // what is inside moves nothing
  answers.widen("gravity", of(0.2, 0.001), {});
  EXPECT_DOUBLE_EQ(answers.findings[0].parameters.at("e").low, 0.168 - 0.024);
}

TEST(Widen, ANameThatAChoiceDoesWithoutIsOneOfASet) {
  WholeAnswers answers = of(0.23, 0.009);
  const WholeAnswers other = of(0.02, 0.01);
  ASSERT_TRUE(other.findings.empty()) << "within its tolerance";
  answers.widen("clock_rate", other, {});
  EXPECT_EQ(answers.findings[0].status, VerdictStatus::one_of);
  EXPECT_EQ(answers.findings[0].one_of, (std::vector<std::string>{"restitution", "clock_rate"}));
  answers.widen("clock_rate", other, {});
  EXPECT_EQ(answers.findings[0].one_of.size(), 2U) << "once";
}

TEST(Widen, AChoiceThatCannotBeAskedSaysNothing) {
  WholeAnswers answers = of(0.23, 0.009);
  const Finding before = answers.findings[0];
  answers.widen("gravity", {}, {});
  EXPECT_EQ(answers.findings[0].status, before.status);
  EXPECT_DOUBLE_EQ(answers.findings[0].parameters.at("e").low, before.parameters.at("e").low);
}

TEST(Answered, TorquesThatWeighTakeThePlaceOfTheFeetsSum) {
  Finding heavy, scale;
  heavy.effect = name_of(WholeFigure::mass_share);
  heavy.one_of = {heavy.effect, name_of(WholeFigure::force_scale)};
  scale.effect = name_of(WholeFigure::force_scale), scale.one_of = {scale.effect};
  for (const bool weighed : {false, true}) {
    Answered all, drives;
    all.answers.findings = {of(0.23, 0.009).findings[0], heavy};
    all.patch.mass_share = 0.1, all.patch.slope = V2(0.01, 0.0);
    drives.answers.findings = {scale}, drives.weighed = weighed;
    drives.patch.slope = V2(0.02, 0.0);
    all.take(drives);
    EXPECT_EQ(all.answers.findings.size(), weighed ? 2U : 3U);
    EXPECT_EQ(all.answers.findings.front().effect, "restitution");
    EXPECT_EQ(all.answers.findings.back().effect, scale.effect) << "what is new stays";
    EXPECT_EQ(all.patch.mass_share.has_value(), !weighed);
    EXPECT_EQ(all.patch.slope->x(), 0.02) << "the later one";
  }
}

TEST(Chance, MoreQuestionsAskForMore) {
  Chance few, many;
  few.whole.questions = 2, many.whole.questions = 200;
  EXPECT_LT(few.deviations(), many.deviations());
  EXPECT_NEAR(few.family_wise(few.deviations()), few.decisions.family_wise, 1e-6);
  EXPECT_NEAR(many.family_wise(many.deviations()), many.decisions.family_wise, 1e-6);
  EXPECT_DOUBLE_EQ(many.family_wise(0.0), 1.0);
}

/// A ball that falls for half a second, as its recording has it.
WholeRecording falling(double lengths, double seconds) {
  recording::Recording r;
  r.file = "fall.csv";
  for (int k = 0; k < 120; ++k) r.t.push_back(0.005 * k * seconds);
  const auto t = [&](std::size_t k) { return r.t[k] / seconds; };
  put(r, "base_p", "xyz",
      [&](auto k, auto i) { return i == 2 ? lengths * (3.0 - 0.5 * 9.81 * t(k) * t(k)) : 0.0; });
  put(r, "base_v", "xyz",
      [&](auto k, auto i) { return i == 2 ? -lengths / seconds * 9.81 * t(k) : 0.0; });
  put(r, "base_w", "xyz", [](auto, auto) { return 0.0; });
  put(r, "base_q", "wxyz", [](auto, auto i) { return i == 0 ? 1.0 : 0.0; });
  const WholeData data = judge_whole({r}, body_of("", kBall), {});
  EXPECT_TRUE(data.defects.empty());
  return data.recordings.front();
}

/// Gravity that a choice makes of the recording, over the choice's own: 1 where it explains it.
double explained(const Choice& c) {
  const WholeRecording& r = c.recordings.front();
  const std::size_t last = r.rows() - 1;
  const double fall = (r.v[last].z() - r.v[0].z()) / (r.t[last] - r.t[0]) / c.known.pose_scale;
  return fall / c.body.model.gravity[2];
}

TEST(Choices, EachOtherNameExplainsTheSameFall) {
  const WholeBody body = body_of("", kBall);
  for (const double share : {0.95, 1.04}) {
    const std::vector<WholeRecording> recordings{falling(share, 1.0)};
    Asking asking{body, recordings, {}, {}, {}, {}, 1};
    const Known before = asking.known;
    asking.known.pose_scale = share;
    int explain = 0;
    for (const Choice& c : other_choices(asking, before, number(share, 0.001))) {
      const bool without = c.name == "pose_scale left out";
      const bool ends = c.name.find("the l") == 0;
      EXPECT_NEAR(explained(c), without ? share : 1.0, ends ? 0.003 : 1e-6) << c.name;
      explain += c.name == "clock_rate" || c.name == "gravity" ? 1 : 0;
    }
    EXPECT_EQ(explain, 2);
  }
}

TEST(Choices, AClockIsUndoneInSecondsAndSpeeds) {
  const WholeBody body = body_of("", kBall);
  constexpr double kClock = 1.03;  // recorded seconds over true ones
  const std::vector<WholeRecording> recordings{falling(1.0, kClock)};
  const Asking asking{body, recordings, {}, {}, {}, {}, 1};
  for (const Choice& c :
       other_choices(asking, asking.known, number(1.0 / (kClock * kClock), 0.001))) {
    if (c.name != "clock_rate") continue;
    EXPECT_NEAR(c.recordings[0].t.back(), 0.005 * 119, 1e-9);
    EXPECT_NEAR(c.recordings[0].v.back().z(), -9.81 * 0.005 * 119, 1e-9);
    EXPECT_NEAR(c.recordings[0].interval, 0.005, 1e-9);
  }
}

TEST(Choices, WhereNobodyFellThereAreNone) {
  const WholeBody body = body_of("", kBall);
  const std::vector<WholeRecording> none;
  const Asking asking{body, none, {}, {}, {}, {}, 1};
  EXPECT_TRUE(other_choices(asking, asking.known, std::nullopt).empty());
}

TEST(Choices, WhatCountsAsAContactIsHalvedAndDoubled) {
  const WholeBody body = body_of("", kBall);
  const std::vector<WholeRecording> recordings{falling(1.0, 1.0)};
  const Asking asking{body, recordings, {}, {}, {}, {}, 1};
  std::vector<double> clearances, spreads;
  for (const Choice& c : other_choices(asking, asking.known, number(1.0, 0.001))) {
    clearances.push_back(c.settings.clearance / asking.settings.clearance);
    spreads.push_back(c.settings.impact_spread / asking.settings.impact_spread);
  }
  for (const std::vector<double>& factors : {clearances, spreads}) {
    EXPECT_EQ(std::count(factors.begin(), factors.end(), 0.5), 1);
    EXPECT_EQ(std::count(factors.begin(), factors.end(), 2.0), 1);
  }
}

TEST(WholeAnswers, WhatALaterQuestionNamesIsTestable) {
  WholeAnswers answers, later;
  answers.cannot("link_mass", "nothing weighs the robot");
  answers.cannot("ground_slope", "no foot that is known to stand");
  Finding f;
  f.effect = "payload", f.one_of = {"payload", "link_mass"};
  later.findings.push_back(f);
  answers.take(later);
  ASSERT_EQ(answers.untestable.size(), 1u);
  EXPECT_EQ(answers.untestable.front().effect, "ground_slope");
}

}  // namespace
}  // namespace sanso::diagnose
