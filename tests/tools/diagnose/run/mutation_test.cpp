// What a person can get wrong about a recording moves the verdict the way it should: a joint
// renamed or swapped, a sign, a unit, a file given twice. And what does not matter does not.
#include <gtest/gtest.h>

#include <functional>

#include "tests/support/noisy_world.h"
#include "tests/support/temp_folder.h"
#include "tools/diagnose/run/diagnose.h"
#include "tools/recording/csv_writer.h"

namespace sanso::diagnose {
namespace {

using namespace test;

using Change = std::function<void(recording::Recording&)>;

std::vector<double> column(const recording::Recording& r, const std::string& name) {
  const auto values = r.find(name);
  return {values.begin(), values.end()};
}

void scaled(recording::Recording& r, const std::string& name, double factor) {
  std::vector<double> values = column(r, name);
  for (double& v : values) v *= factor;
  r.set(name, values);
}

void rename(recording::Recording& r, const std::string& from, const std::string& to) {
  for (recording::Channel& c : r.channels) {
    if (c.name == from) c.name = to;
  }
}

void swap_columns(recording::Recording& r, const std::string& a, const std::string& b) {
  rename(r, a, "spare");
  rename(r, b, a);
  rename(r, "spare", b);
}

/// Two links whose lower joint rubs more than the model says, recorded, changed, and diagnosed.
class Mutation : public ::testing::Test {
 protected:
  Diagnosis diagnosed(const Change& change, const std::string& at = "b",
                      const std::vector<std::size_t>& order = {0, 1}) {
    const ModelFolder model = two_links(kNoisyServo);
    DiagnoseOptions options;
    options.model = (folder_.path() / "model").string();
    options.quiet = true;
    options.effects = {"coulomb_friction", "viscous_friction", "command_delay"};
    write_model_folder(model, options.model);
    const EffectEntry rubs = hidden("coulomb_friction", at, {{"coulomb", 0.09}});
    std::vector<recording::Recording> all = recordings_of(hiding(model, {rubs}), 2, 4.0, 11);
    for (const std::size_t k : order) {
      change(all[k]);
      options.recordings.push_back((folder_.path() / all[k].file).string());
      recording::write_csv(all[k], options.recordings.back());
    }
    return diagnose(options, [](const std::string&) {});
  }
  const Diagnosis& plain();
  sanso::test::TempFolder folder_;
};

const Change kNothing = [](recording::Recording&) {};

void expect_refused(const Verdict& v, const std::string& defect) {
  EXPECT_EQ(v.status, VerdictStatus::refused) << v.answer;
  ASSERT_FALSE(v.refused.empty());
  EXPECT_EQ(v.refused[0].defect, defect) << v.answer;
  EXPECT_FALSE(v.mismatch);
  EXPECT_TRUE(v.findings.empty());
}

/// The diagnosis without any change, made once.
const Diagnosis& Mutation::plain() {
  static const Diagnosis once = diagnosed(kNothing);
  return once;
}

TEST_F(Mutation, NoneNamesWhatWasHiddenAndWhere) {
  const Verdict& v = plain().verdict;
  ASSERT_EQ(v.findings.size(), 1u) << v.answer;
  EXPECT_EQ(v.findings[0].effect, "coulomb_friction");
  EXPECT_EQ(v.findings[0].where, std::vector<std::string>{"b"});
  const VerdictParameter& size = v.findings[0].parameters.at("coulomb");
  EXPECT_LE(size.low, 0.09);
  EXPECT_GE(size.high, 0.09);
}

TEST_F(Mutation, TheOtherJointRubbingMovesTheFindingThere) {
  const Verdict v = diagnosed(kNothing, "a").verdict;
  ASSERT_EQ(v.findings.size(), 1u) << v.answer;
  EXPECT_EQ(v.findings[0].where, std::vector<std::string>{"a"});
}

TEST_F(Mutation, AJointOfAnotherNameIsMissing) {
  const Verdict v = diagnosed([](recording::Recording& r) {
                      rename(r, "q:b", "q:elbow");
                      rename(r, "u:b", "u:elbow");
                    }).verdict;
  EXPECT_EQ(v.status, VerdictStatus::refused);
  EXPECT_NE(v.answer.find("q:b"), std::string::npos) << v.answer;
}

TEST_F(Mutation, SwappedPositionsAreSwappedJoints) {
  expect_refused(diagnosed([](recording::Recording& r) { swap_columns(r, "q:a", "q:b"); }).verdict,
                 defect::kSwapped);
}

TEST_F(Mutation, JointsSwappedInEveryChannelMoveTheFinding) {
  // commands and positions of the two change names together: another robot, which is no rubbing one
  const Verdict v = diagnosed([](recording::Recording& r) {
                      swap_columns(r, "q:a", "q:b");
                      swap_columns(r, "u:a", "u:b");
                    }).verdict;
  EXPECT_TRUE(v.mismatch) << v.answer;
  EXPECT_NE(v.status, VerdictStatus::confirmed) << v.answer;
}

TEST_F(Mutation, AFlippedPositionIsAWrongSign) {
  expect_refused(diagnosed([](recording::Recording& r) { scaled(r, "q:b", -1.0); }).verdict,
                 defect::kWrongSign);
}

TEST_F(Mutation, DegreesAreAWrongUnit) {
  for (const char* channel : {"q:a", "q:b", "u:b"}) {
    const Verdict v =
        diagnosed([&](recording::Recording& r) { scaled(r, channel, 57.29577951); }).verdict;
    expect_refused(v, defect::kWrongUnit);
    EXPECT_EQ(v.refused[0].channel, channel);
  }
}

TEST_F(Mutation, MillisecondsAreAWrongUnit) {
  expect_refused(diagnosed([](recording::Recording& r) {
                   for (double& t : r.t) t *= 1000.0;
                 }).verdict,
                 defect::kWrongUnit);
}

TEST_F(Mutation, ARecordingGivenTwiceIsACopy) {
  const Diagnosis d = [&] {
    DiagnoseOptions options;
    options.model = (folder_.path() / "model").string();
    write_model_folder(two_links(kNoisyServo), options.model);
    const auto recordings = recordings_of(two_links(kNoisyServo), 1, 4.0, 3);
    for (const char* name : {"one.csv", "two.csv"}) {
      options.recordings.push_back((folder_.path() / name).string());
      recording::write_csv(recordings[0], options.recordings.back());
    }
    return diagnose(options, [](const std::string&) {});
  }();
  expect_refused(d.verdict, defect::kCopyOfFile);
  EXPECT_NE(d.verdict.answer.find("two.csv"), std::string::npos);
}

TEST_F(Mutation, OrderOfFilesStartOfTheClockAndColumnsOfNobodyDoNotMatter) {
  const Verdict other = diagnosed(
                            [](recording::Recording& r) {
                              for (double& t : r.t) t += 64.0;
                              r.set("q:neck", std::vector<double>(r.rows(), 0.3));
                            },
                            "b", {1, 0})
                            .verdict;
  ASSERT_EQ(other.findings.size(), 1u) << other.answer;
  EXPECT_EQ(other.findings[0].effect, plain().verdict.findings.at(0).effect);
  EXPECT_EQ(other.findings[0].where, plain().verdict.findings.at(0).where);
  EXPECT_NEAR(other.findings[0].parameters.at("coulomb").value,
              plain().verdict.findings.at(0).parameters.at("coulomb").value, 0.003);
}

TEST_F(Mutation, ThePatchedModelKnowsWhatWasFoundAndExplainsWhatWasHeldOut) {
  ASSERT_TRUE(plain().patched.has_value());
  bool found = false;
  for (const EffectEntry& e : plain().patched->effects)
    found |= e.id == "coulomb_friction" && e.where == std::vector<std::string>{"b"};
  EXPECT_TRUE(found);
  for (const auto& [horizon, scores] : plain().verdict.heldout) {
    ASSERT_TRUE(scores.all.has_value()) << horizon.text();
    EXPECT_LE(scores.all->patched, scores.all->nominal) << horizon.text();
  }
  EXPECT_GT(plain().verdict.heldout.at(Horizon::ahead(0.5)).all->explained(), 0.8);
  EXPECT_FALSE(plain().verdict.heldout_recordings.empty());
}

TEST_F(Mutation, EveryFileHasItsOwnHash) {
  std::vector<std::string> hashes;
  for (const auto& [file, hash] : plain().verdict.data_hash) hashes.push_back(hash);
  ASSERT_EQ(hashes.size(), 2u);
  EXPECT_NE(hashes[0], hashes[1]);
}

}  // namespace
}  // namespace sanso::diagnose
