// Verdicts against answers of other generators: what counts as right, family by family.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "shared/files/input_error.h"
#include "tests/support/temp_folder.h"
#include "tools/bench/diagnose/folder_bench.h"

namespace sanso::bench {
namespace {

CaseAnswer single() {
  return parse_answer(R"({"family":"single","robot":"arm","variant":"torque",
    "severity":{"achieved_snr":12.0},"noise":{"rms":0.001},"oracle":{"explained":0.9},
    "effects":[{"id":"joint_stop","where":["elbow"],"where_accept":["elbow","lower"],
      "also":["cable_spring"],
      "parameters":{"limit":{"value":-0.5,"compare":true,"aliases":["angle"],
                             "other_forms":[[0.25,0]]}}}]})",
                      "answer.json");
}

std::string finding(const std::string& id, const std::string& where, const std::string& more = "") {
  return R"({"effect":")" + id + R"(","where":[")" + where +
         R"("],"status":"CONFIRMED","one_of":[")" + id + R"("])" + more + "}";
}
std::string verdict(const std::string& status, const std::string& findings) {
  return R"({"status":")" + status + R"(","mismatch":)" + (status == "ABSENT" ? "false" : "true") +
         R"(,"findings":[)" + findings + "]}";
}

TEST(CaseFolder, ASingleEffectIsRightOnlyByNamePlaceAndAlone) {
  const CaseAnswer truth = single();
  EXPECT_EQ(truth.robot, "arm/torque");
  EXPECT_TRUE(judge(truth, verdict("CONFIRMED", finding("joint_stop", "elbow"))).right);
  EXPECT_TRUE(judge(truth, verdict("CONFIRMED", finding("cable_spring", "lower"))).right);
  const CaseJudgement misplaced = judge(truth, verdict("CONFIRMED", finding("joint_stop", "hip")));
  EXPECT_TRUE(misplaced.named_first);
  EXPECT_FALSE(misplaced.right);
  const CaseJudgement more = judge(
      truth,
      verdict("CONFIRMED", finding("joint_stop", "elbow") + "," + finding("cogging", "elbow")));
  EXPECT_FALSE(more.right);
  EXPECT_EQ(more.wrong_confirmed, 1);
  EXPECT_FALSE(judge(truth, verdict("ABSENT", "")).right);
}

TEST(CaseFolder, WhatAGeneratorCouldNotTellIsZero) {
  const CaseAnswer answer = parse_answer(R"({"family":"null","robot":"arm","effects":[],
    "severity":null,"noise":{"rms":null},"oracle":{"explained":null}})",
                                         "answer.json");
  EXPECT_EQ(answer.ratio, 0.0);
  EXPECT_EQ(answer.noise, 0.0);
  EXPECT_EQ(answer.oracle_explained, 0.0);
}

TEST(CaseFolder, ANameInsideASetIsInTheSetAndNotFirst) {
  const CaseJudgement j =
      judge(single(), verdict("ONE_OF", R"({"effect":"tether","where":["lower"],"status":"ONE_OF",
                                            "one_of":["tether","joint_stop"]})"));
  EXPECT_TRUE(j.in_set && j.place_right);
  EXPECT_FALSE(j.named_first || j.right);
  EXPECT_EQ(j.wrong_confirmed, 0);
  EXPECT_DOUBLE_EQ(j.set_size, 2.0);
}

TEST(CaseFolder, AParameterCountsInTheFormThatItWasFittedIn) {
  const CaseJudgement j = judge(single(), verdict("CONFIRMED", finding("joint_stop", "elbow",
                                                                       R"(,"parameters":{"angle":
                                   {"value":0.26,"low":0.24,"high":0.28}})")));
  EXPECT_NEAR(j.relative_error.at("joint_stop.limit"), 0.04, 1e-12);
  EXPECT_TRUE(j.covered.at("joint_stop.limit"));
  const CaseJudgement off = judge(single(), verdict("CONFIRMED", finding("joint_stop", "elbow",
                                                                         R"(,"parameters":{"limit":
                                {"value":-0.4,"low":-0.45,"high":-0.35}})")));
  EXPECT_NEAR(off.relative_error.at("joint_stop.limit"), 0.2, 1e-12);
  EXPECT_FALSE(off.covered.at("joint_stop.limit"));
}

TEST(CaseFolder, ADecoyIsRefusedByItsChannelOnly) {
  const CaseAnswer answer = parse_answer(
      R"({"family":"decoy","robot":"arm","effects":[],
          "decoy":{"kind":"x","channels":["u:","q:a"]}})",
      "answer.json");
  const auto refusal = [&](const std::string& status, const std::string& channel) {
    return judge(answer, R"({"status":")" + status +
                             R"(","mismatch":false,"refused":[{"channel":")" + channel + R"("}]})")
        .right;
  };
  EXPECT_TRUE(refusal("REFUSED", "u:knee"));
  EXPECT_TRUE(refusal("REFUSED", "q:a"));
  EXPECT_FALSE(refusal("REFUSED", "q:b"));
  EXPECT_FALSE(refusal("ABSENT", "q:a"));
}

TEST(CaseFolder, WhatTheLibraryLacksMustStayUnnamed) {
  const CaseAnswer answer = parse_answer(
      R"({"family":"outside","robot":"arm","effects":[{"id":"new_physics","where":["a"]}]})", "f");
  EXPECT_TRUE(judge(answer, verdict("PRESENT_UNNAMED", "")).right);
  EXPECT_FALSE(judge(answer, verdict("PRESENT_UNNAMED", finding("cogging", "a"))).right);
  EXPECT_FALSE(judge(answer, verdict("ABSENT", "")).right);
}

TEST(CaseFolder, AnAmbiguousCaseWantsTheWholeSet) {
  const CaseAnswer answer = parse_answer(
      R"({"family":"ambiguous","robot":"arm","one_of":["a","b"],
          "effects":[{"id":"a","where":["j"],"also":["b"]}]})",
      "f");
  const auto set = [&](const std::string& ids) {
    return judge(answer, verdict("ONE_OF", R"({"effect":"a","where":["j"],"status":"ONE_OF",
                                              "one_of":[)" +
                                               ids + "]}"))
        .right;
  };
  EXPECT_TRUE(set(R"("a","b")"));
  EXPECT_TRUE(set(R"("a","b","c")"));
  EXPECT_FALSE(set(R"("a","c")"));
}

TEST(CaseFolder, UnreadableCasesNameTheFile) {
  const test::TempFolder folder;
  EXPECT_THROW(read_cases((folder.path() / "none").string()), files::InputError);
  EXPECT_THROW(read_cases(folder.path().string()), files::InputError);
  std::filesystem::create_directories(folder.path() / "case_1");
  const auto answer = folder.path() / "case_1" / "answer.json";
  std::ofstream(answer) << R"({"family": 3})";
  try {
    read_cases(folder.path().string());
    FAIL() << "read";
  } catch (const files::InputError& error) {
    EXPECT_EQ(error.file, answer.string());
  }
  std::ofstream(answer) << R"({"family":"null","robot":"arm","effects":[]})";
  EXPECT_THROW(read_cases(folder.path().string()), files::InputError) << "no recordings";
  std::ofstream(folder.path() / "case_1" / "rec_1.csv") << "t\n";
  EXPECT_EQ(read_cases(folder.path().string()).front().recordings.size(), 1u);
}

TEST(ExplainedShare, IsOneAtTheNoiseAndZeroWithoutChange) {
  const std::vector<double> before{0.01, 0.02, 0.5}, noise(3, 0.001);
  for (const bool bounded : {false, true}) {
    EXPECT_NEAR(explained_share(before, noise, 0.001, bounded), 1.0, 1e-12);
    EXPECT_EQ(explained_share(before, before, 0.001, bounded), 0.0);
  }
}

TEST(ExplainedShare, OneDivergedWindowDoesNotDecideTheBoundedMeasure) {
  std::vector<double> before(50, 0.01), after(50, 0.001);
  before[7] = after[7] = 30.0;  // diverges with and without the patch
  EXPECT_LT(explained_share(before, after, 0.001, false), 0.01);
  EXPECT_GT(explained_share(before, after, 0.001, true), 0.7);
}

TEST(CaseFolder, FamiliesHaveOneNameHereAndOneInAnswers) {
  for (const CaseFamily family : {CaseFamily::ambiguous, CaseFamily::decoy, CaseFamily::clean,
                                  CaseFamily::outside, CaseFamily::pair, CaseFamily::single}) {
    EXPECT_EQ(family_from_string(to_string(family)), family);
    EXPECT_EQ(family_from_string(in_answers(family)), family);
  }
  EXPECT_FALSE(family_from_string("triple"));
  try {
    parse_answer(R"({"family":"triple","robot":"arm","effects":[]})", "answer.json");
    FAIL();
  } catch (const files::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("answer.json: unknown family \"triple\""),
              std::string::npos)
        << error.what();
  }
}

TEST(BoundedError, GrowsAsTheSquareNearTheNoiseAndAsALogarithmFarAway) {
  EXPECT_NEAR(bounded_error(1e-4, 1e-3), 0.01, 1e-5);
  EXPECT_LT(bounded_error(1.0, 1e-3), 500.0);
  EXPECT_GT(bounded_error(2.0, 1e-3), bounded_error(1.0, 1e-3));
}

CaseOutcome outcome(const std::string& name, CaseFamily family, const std::string& robot,
                    double ratio) {
  CaseOutcome o;
  o.name = name, o.family = family, o.robot = robot, o.ratio = ratio;
  o.seconds = 1.0, o.cpu_seconds = 2.0;
  return o;
}

TEST(FolderTable, CountsFamiliesRatiosRobotsAndTimes) {
  std::vector<CaseOutcome> all{outcome("a", CaseFamily::single, "arm", 5.0),
                               outcome("b", CaseFamily::single, "arm", 50.0),
                               outcome("c", CaseFamily::clean, "pendulum", 0.0)};
  all[0].said.right = all[0].said.detected = all[2].said.detected = true;
  const std::string table = folder_table(all, {0.0, 3.0, 10.0});
  EXPECT_NE(table.find("single     all            right 50 %"), std::string::npos) << table;
  EXPECT_NE(table.find("3 to 10        right 100 %"), std::string::npos) << table;
  EXPECT_NE(table.find("10 and more    right 0 %"), std::string::npos) << table;
  EXPECT_NE(table.find("false alarms 100 %"), std::string::npos) << table;
  EXPECT_NE(table.find("  b: single arm ratio 50.0"), std::string::npos) << table;
}

TEST(FolderBench, GoesOnBehindACaseWhoseHeldOutRecordingIsBroken) {
  const test::TempFolder folder;
  for (const char* name : {"one", "two"}) {
    const std::filesystem::path at = folder.path() / "cases" / name;
    std::filesystem::create_directories(at / "heldout");
    std::filesystem::copy("tools/diagnose/examples/passive_pendulum", at / "model");
    std::ofstream(at / "rec_1.csv") << "t,q:joint\n0,0\n0.01,0\n";
    std::ofstream(at / "heldout" / "rec_1.csv") << "t,q:other\n0,0\n0.01,0\n";
    std::ofstream(at / "answer.json") << R"({"family":"decoy","robot":"pendulum","effects":[],
      "severity":null,"noise":{"rms":0.001},"decoy":{"kind":"short"}})";
  }
  FolderBenchOptions options;
  options.folder = (folder.path() / "cases").string();
  options.out = (folder.path() / "out").string();
  EXPECT_EQ(bench_folder(options), 0);
  for (const char* name : {"one", "two"})
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "out" / name / "outcome.json"));
}

}  // namespace
}  // namespace sanso::bench
