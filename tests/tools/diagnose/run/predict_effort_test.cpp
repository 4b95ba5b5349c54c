// `sanso diagnose --predict effort` on files: what it names, what it does not, what it writes, what
// it refuses; and the verdict of outcomes written by hand.
#include "tools/diagnose/run/predict_effort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/noisy_world.h"
#include "tests/support/temp_folder.h"
#include "tools/recording/csv_writer.h"

namespace sanso::diagnose {
namespace {

using test::hidden, test::hiding;
using Names = std::vector<std::string>;

constexpr const char* kTorque =
    "actuator = \"torque\"\ntorque_limit = 0.0\nviscous = 0.05\n"
    "armature = 0.01\nposition_noise = 0.0001\n";

ModelFolder model() { return test::two_links(kTorque); }
ModelFolder rubbing() {
  return hiding(model(), {hidden("coulomb_friction", "a", {{"coulomb", 0.2}})});
}

/// Twenty seconds of two sines of torque at every joint.
recording::Recording swing(const ModelFolder& world, std::uint64_t noise_seed) {
  const Drive drive = test::make_test_drive(world, 20.0, 0.004, [](int j, double t) {
    return 1.5 * (std::sin((2.1 + 1.3 * j) * t) + 0.6 * std::sin((5.3 + 0.9 * j) * t + j));
  });
  test::Recorded how;
  how.noise_seed = noise_seed;
  return test::record(world, drive, how);
}

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream out;
  out << std::ifstream(file).rdbuf();
  return out.str();
}

class PredictEffort : public testing::Test {
 protected:
  void given(const ModelFolder& nominal, const recording::Recording& data) {
    write_model_folder(nominal, (folder_ / "given").string());
    options_.model = (folder_ / "given").string();
    options_.recordings = {(folder_ / "swing.csv").string()};
    options_.out = (folder_ / "out").string();
    options_.quiet = true;
    recording::write_csv(data, options_.recordings.front());
  }
  /// Exit code of the command; its words stay out of the test's.
  int run() {
    testing::internal::CaptureStdout();
    const int code = run_predict_effort(options_);
    printed_ = testing::internal::GetCapturedStdout();
    return code;
  }
  nlohmann::json verdict() const {
    return nlohmann::json::parse(text_of(folder_ / "out" / "verdict.json"));
  }
  sanso::test::TempFolder temporary_;
  std::filesystem::path folder_ = temporary_.path();
  DiagnoseOptions options_;
  std::string printed_;
};

TEST_F(PredictEffort, NamesHiddenFrictionAndProvesItOnTheHeldOutPart) {
  given(model(), swing(rubbing(), 11));
  EXPECT_EQ(run(), 1);
  const nlohmann::json v = verdict();
  EXPECT_EQ(v.at("status"), "CONFIRMED") << v.at("answer");
  EXPECT_EQ(v.at("mismatch"), true);
  ASSERT_EQ(v.at("findings").size(), 1u) << v.at("answer");
  const nlohmann::json& f = v.at("findings").at(0);
  EXPECT_EQ(f.at("effect"), "coulomb_friction");
  EXPECT_EQ(f.at("where"), Names{"a"});
  EXPECT_EQ(f.at("one_of"), Names{"coulomb_friction"});
  const nlohmann::json& p = f.at("parameters").at("coulomb");
  EXPECT_NEAR(p.at("value").get<double>(), 0.2, 0.02);
  EXPECT_LT(p.at("low").get<double>(), p.at("value").get<double>());
  EXPECT_GT(p.at("high").get<double>(), p.at("value").get<double>());
  EXPECT_EQ(p.at("unit"), "N m");
  EXPECT_GT(f.at("evidence").at("heldout_gain_low").get<double>(), 0.0);
  const nlohmann::json& heldout = v.at("fit").at("heldout");
  ASSERT_EQ(heldout.size(), 1u) << "the motion is given: there is no horizon but now";
  const nlohmann::json& a = heldout.at("0s").at("channels").at("tau_cmd:a");
  EXPECT_LT(a.at("patched").get<double>(), 0.5 * a.at("nominal").get<double>());
  EXPECT_GT(a.at("explained").get<double>(), 0.8);
  EXPECT_TRUE(heldout.at("0s").at("channels").contains("tau_cmd:b"));
  EXPECT_EQ(v.at("fit").at("recordings"), Names{"last 40 % of " + options_.recordings.front()});
  EXPECT_TRUE(v.at("refused").empty());
  EXPECT_EQ(v.at("data_hash").size(), 1u);
  EXPECT_NE(text_of(folder_ / "out" / "report.html").find("coulomb_friction"), std::string::npos);
  EXPECT_NE(printed_.find("coulomb_friction.coulomb at a"), std::string::npos) << printed_;
}

TEST_F(PredictEffort, ThePatchedModelMissesNothingOfTheSameData) {
  given(model(), swing(rubbing(), 11));
  ASSERT_EQ(run(), 1);
  const ModelFolder patched = read_model_folder((folder_ / "out" / "model").string());
  ASSERT_EQ(patched.effects.size(), 1u);
  EXPECT_EQ(patched.effects.front().id, "coulomb_friction");
  options_.model = (folder_ / "out" / "model").string();
  options_.out = (folder_ / "again").string();
  EXPECT_EQ(run(), 0) << printed_;
  EXPECT_EQ(nlohmann::json::parse(text_of(folder_ / "again" / "verdict.json")).at("status"),
            "ABSENT");
}

TEST_F(PredictEffort, ACleanWorldIsAbsentAndTheModelStaysAsItWas) {
  given(model(), swing(model(), 3));
  EXPECT_EQ(run(), 0) << printed_;
  const nlohmann::json v = verdict();
  EXPECT_EQ(v.at("status"), "ABSENT");
  EXPECT_EQ(v.at("mismatch"), false);
  EXPECT_TRUE(v.at("findings").empty());
  EXPECT_TRUE(v.at("unexplained").is_null());
  EXPECT_EQ(v.at("fit").at("heldout").size(), 1u) << "scores are told without a mismatch, too";
  EXPECT_TRUE(read_model_folder((folder_ / "out" / "model").string()).effects.empty());
}

TEST_F(PredictEffort, WhatItMayNotNameStaysUnnamedWhereItIs) {
  given(model(), swing(rubbing(), 11));
  options_.effects = {"cable_spring"};
  EXPECT_EQ(run(), 1) << printed_;
  const nlohmann::json v = verdict();
  EXPECT_EQ(v.at("status"), "PRESENT_UNNAMED") << v.at("answer");
  for (const nlohmann::json& f : v.at("findings")) EXPECT_EQ(f.at("effect"), "cable_spring");
  ASSERT_FALSE(v.at("unexplained").is_null());
  EXPECT_EQ(v.at("unexplained").at("where"), "a");
  EXPECT_GT(v.at("unexplained").at("energy_share").get<double>(), 0.5);
}

TEST_F(PredictEffort, PrintsTheFileAndTheSameSeedWritesTheSameBytes) {
  given(model(), swing(rubbing(), 5));
  options_.json = true, options_.seed = 7;
  run();
  const std::string first = text_of(folder_ / "out" / "verdict.json");
  EXPECT_EQ(printed_, first);
  EXPECT_EQ(verdict().at("seed"), 7);
  run();
  EXPECT_EQ(printed_, first);
}

TEST_F(PredictEffort, RefusesARecordingWithoutAnyEffort) {
  const ModelFolder servo = test::pendulum(test::kNoisyServo);
  given(servo, test::recordings_of(servo, 1, 10.0, 1).front());  // u: and q: alone
  EXPECT_EQ(run(), 2);
  const nlohmann::json v = verdict();
  EXPECT_EQ(v.at("status"), "REFUSED");
  ASSERT_EQ(v.at("refused").size(), 1u);
  const nlohmann::json& defect = v.at("refused").at(0);
  EXPECT_EQ(defect.at("defect"), "no effort");
  EXPECT_EQ(defect.at("file"), options_.recordings.front());
  EXPECT_EQ(defect.at("channel"), "tau:");
  const std::string message = defect.at("message");
  for (const char* word : {"swing.csv", "expected", "tau_cmd:", "pwm:", "passive"})
    EXPECT_NE(message.find(word), std::string::npos) << word << ": " << message;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "model")) << "a refusal patches nothing";
  EXPECT_NE(text_of(folder_ / "out" / "report.html").find("no effort"), std::string::npos);
  EXPECT_NE(printed_.find("refused"), std::string::npos);
}

// ---- verdicts of outcomes that are changed by hand

class EffortVerdict : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    rows_ = new EffortRows(effort_rows(model(), {swing(rubbing(), 11)}, false, Settings{}));
    found_ = new EffortOutcome(explain_effort(*rows_, Settings{}, {}));
  }
  static void TearDownTestSuite() { delete rows_, delete found_; }
  void SetUp() override {
    outcome_ = *found_;
    ASSERT_EQ(outcome_.terms.size(), 1u);
    ASSERT_EQ(outcome_.scores.front().joint, "a");
  }
  Verdict verdict() const { return effort_verdict(outcome_, *rows_, {}); }
  JudgedTerm& friction() { return outcome_.terms.front(); }
  static bool notes_hold(const Names& notes, const std::string& words) {
    return std::any_of(notes.begin(), notes.end(), [&](const std::string& note) {
      return note.find(words) != std::string::npos;
    });
  }
  static EffortRows* rows_;
  static EffortOutcome* found_;
  EffortOutcome outcome_;
};
EffortRows* EffortVerdict::rows_ = nullptr;
EffortOutcome* EffortVerdict::found_ = nullptr;

TEST_F(EffortVerdict, NamesNothingAtAJointThatBeatsNotBothNominalAndConstant) {
  EXPECT_EQ(verdict().findings.size(), 1u);
  for (const bool constant : {false, true}) {
    outcome_ = *found_;
    EffortScore& a = outcome_.scores.front();
    (constant ? a.constant : a.nominal) = 0.99 * a.patched;
    const Verdict v = verdict();
    EXPECT_TRUE(v.findings.empty()) << v.answer;
    EXPECT_TRUE(notes_hold(v.notes, "described, not named: coulomb_friction at a: the joint's"));
    EXPECT_NE(v.status, VerdictStatus::confirmed);
  }
  // the other joint's score takes no name away here
  outcome_ = *found_;
  outcome_.scores.back().constant = 0.0;
  EXPECT_EQ(verdict().findings.size(), 1u);
}

TEST_F(EffortVerdict, NamesNothingWhoseGainIsChance) {
  friction().predicts = false;
  const Verdict v = verdict();
  EXPECT_TRUE(v.findings.empty());
  EXPECT_TRUE(notes_hold(v.notes, "not beyond chance"));
}

TEST_F(EffortVerdict, NamesThatDoAsWellAreOneOf) {
  friction().equally_good = {"viscous_friction", "air_drag"};
  const Verdict v = verdict();
  EXPECT_EQ(v.status, VerdictStatus::one_of);
  EXPECT_TRUE(v.mismatch);
  EXPECT_EQ(v.findings.front().one_of, (Names{"coulomb_friction", "viscous_friction", "air_drag"}));
  EXPECT_NE(v.answer.find("one of {coulomb_friction, viscous_friction, air_drag} at a"),
            std::string::npos)
      << v.answer;
  friction().spans_null = true;
  EXPECT_EQ(verdict().status, VerdictStatus::present_unnamed) << "its interval holds zero";
}

TEST_F(EffortVerdict, ABoundThatIsMetIsNoConfirmationButZeroIsNoBound) {
  friction().values.front().at_bound = true;
  EXPECT_EQ(verdict().status, VerdictStatus::present_unnamed);
  friction().values.front().value = 0.0;
  EXPECT_EQ(verdict().status, VerdictStatus::confirmed);
}

TEST_F(EffortVerdict, TellsEveryJointsScoresAndEveryDrivesGain) {
  outcome_.gains = {{"a", "A", 0.25, 0.2, 0.3, false, true}, {"b", "A", 1, 1, 1, false, false}};
  const Verdict v = verdict();
  ASSERT_EQ(v.heldout.size(), 1u);
  const HorizonScores& scores = v.heldout.at(Horizon::recorded_motion());
  for (const EffortScore& s : outcome_.scores) {
    EXPECT_EQ(scores.channels.at(s.channel).nominal, s.nominal);
    EXPECT_EQ(scores.channels.at(s.channel).patched, s.patched);
    EXPECT_NE(effort_table(outcome_).find(s.channel), std::string::npos);
  }
  EXPECT_TRUE(notes_hold(v.notes, "drive gain of a: 0.25 N m for 1 A [0.2, 0.3]"));
  EXPECT_TRUE(notes_hold(v.notes, "drive gain of b: not determined"));
}

/// A term that was found, of any name.
JudgedTerm term(const std::string& effect, const Names& parameters,
                const std::vector<double>& values, double order = 0.0) {
  JudgedTerm out;
  out.term.effect = effect, out.term.where = {"a"}, out.term.parameters = parameters;
  if (order > 0.0) out.term.fixed["order"] = order;
  for (const double x : values) out.values.push_back({x, x, x, "N m", false});
  out.predicts = true;
  return out;
}

TEST(EffortPatched, HoldsWhatTheSimulatorHasAndSaysWhatItHasNot) {
  EffortOutcome outcome;
  outcome.terms = {term("effort_offset", {"torque"}, {0.3}),
                   term("torque_constant", {"effort_share"}, {0.25}),
                   term("coupled_drive", {"coulomb", "viscous", "armature"}, {0.1, 0.1, 0.1}),
                   term("cogging", {"sine", "cosine"}, {0.01, 0.02}, 5),
                   term("cogging", {"sine", "cosine"}, {0.05, 0.0}, 7),
                   term("viscous_friction", {"viscous"}, {0.4})};
  outcome.terms.back().predicts = false;
  const auto [out, notes] = effort_patched(model(), outcome);
  ASSERT_EQ(out.effects.size(), 3u);
  EXPECT_EQ(out.effects[0].id, "cable_spring");
  EXPECT_EQ(out.effects[0].parameters.at("torque"), -0.3) << "a spring pulls against the effort";
  EXPECT_EQ(out.effects[1].id, "torque_constant");
  EXPECT_NEAR(out.effects[1].parameters.at("torque"), 0.8, 1e-12);
  EXPECT_EQ(out.effects[2].parameters.at("order"), 7.0) << "the larger ripple";
  ASSERT_EQ(notes.size(), 2u) << testing::PrintToString(notes);
  EXPECT_TRUE(notes[0].starts_with("coupled_drive at a")) << notes[0];
  EXPECT_TRUE(notes[1].starts_with("cogging at a (order 5)")) << notes[1];
}

}  // namespace
}  // namespace sanso::diagnose
