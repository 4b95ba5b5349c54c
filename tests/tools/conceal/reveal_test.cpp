// Revealing: each family's right answer, and wrong ones that must not pass.
#include "tools/conceal/reveal.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "tools/conceal/seal.h"
#include "tools/plant/world_error.h"

namespace sanso::conceal {
namespace {

struct Reveal : testing::Test {
  Reveal()
      : directory((std::filesystem::temp_directory_path() / ("reveal_" + std::to_string(getpid())))
                      .string()) {
    std::filesystem::create_directories(directory);
  }
  ~Reveal() override { std::filesystem::remove_all(directory); }
  Score score(const std::string& answer, const std::string& verdict) {
    const auto sealed = make_seal(answer);
    std::ofstream(directory + "/answer.sealed", std::ios::binary)
        .write(reinterpret_cast<const char*>(sealed.data()),
               static_cast<std::streamsize>(sealed.size()));
    std::ofstream(directory + "/verdict.json") << verdict;
    return reveal(directory, directory + "/verdict.json");
  }
  std::string directory;
};

constexpr char kBacklash[] =
    R"({"robot":"arm","seed":1,"family":"single","ratio_target":10,"twins":[],
"effects":[{"id":"backlash","where":["elbow"],
        "parameters":{"width":0.02},"ratio":9.7}]})";

TEST_F(Reveal, RightNameRightPlace) {
  const Score s = score(
      kBacklash,
      R"({"mismatch":true,"status":"CONFIRMED","findings":[{"effect":"backlash","where":["elbow"],
      "parameters":{"width":{"value":0.021,"low":0.0195,"high":0.0225}},"one_of":["backlash"]}]})");
  EXPECT_TRUE(s.right && s.named_first && s.where_exact && s.in_set);
  EXPECT_DOUBLE_EQ(s.f1, 1.0);
  EXPECT_NEAR(s.relative_error.at("backlash.width"), 0.05, 1e-9);
  EXPECT_TRUE(s.covered.at("backlash.width"));
}

TEST_F(Reveal, TruthInsideTheSetCountsForTheSetOnly) {
  const Score s = score(
      kBacklash, R"({"mismatch":true,"status":"ONE_OF","findings":[{"effect":"coulomb_friction",
      "where":["elbow"],"one_of":["coulomb_friction","backlash"]}]})");
  EXPECT_TRUE(s.in_set);
  EXPECT_FALSE(s.named_first);
  EXPECT_DOUBLE_EQ(s.set_size, 2.0);
}

TEST_F(Reveal, WrongNameWrongPlaceAndSilenceAreWrong) {
  EXPECT_FALSE(score(kBacklash,
                     R"({"mismatch":true,"status":"CONFIRMED","findings":[{"effect":"cogging",)"
                     R"("where":["elbow"]}]})")
                   .right);
  EXPECT_FALSE(score(kBacklash,
                     R"({"mismatch":true,"status":"CONFIRMED","findings":[{"effect":"backlash",)"
                     R"("where":["shoulder"]}]})")
                   .where_exact);
  EXPECT_FALSE(score(kBacklash, R"({"mismatch":false,"status":"ABSENT"})").right);
}

/// A ripple of friction needs friction to ripple: it is in the world too.
TEST_F(Reveal, WhatAnEffectBroughtAlongIsNoMistakeAndNoMerit) {
  constexpr char kRipple[] =
      R"({"robot":"arm","seed":1,"family":"single","ratio_target":10,"twins":[],
      "effects":[{"id":"position_friction","where":["elbow"],"parameters":{"sine":0.05},
      "ratio":9.7,"beside":{"coulomb_friction":0.04}}]})";
  const std::string coulomb =
      R"({"effect":"coulomb_friction","where":["elbow"],"status":"CONFIRMED"})";
  const std::string ripple =
      R"({"effect":"position_friction","where":["elbow"],"status":"CONFIRMED"})";
  const std::string backlash = R"({"effect":"backlash","where":["elbow"],"status":"CONFIRMED"})";
  const auto said = [&](const std::string& findings) {
    return score(kRipple,
                 R"({"mismatch":true,"status":"CONFIRMED","findings":[)" + findings + "]}");
  };
  const Score both = said(ripple + "," + coulomb);
  EXPECT_TRUE(both.right);
  EXPECT_DOUBLE_EQ(both.f1, 1.0);
  EXPECT_EQ(both.confirmed, 2);
  EXPECT_EQ(both.wrong_confirmed, 0);
  const Score alone = said(coulomb);
  EXPECT_FALSE(alone.right || alone.named_first);
  EXPECT_DOUBLE_EQ(alone.f1, 0.0);
  EXPECT_EQ(alone.wrong_confirmed, 0);
  EXPECT_EQ(said(ripple + "," + backlash).wrong_confirmed, 1);
  EXPECT_LT(said(ripple + "," + backlash).f1, 1.0);
}

TEST_F(Reveal, CleanIsRightOnlyWhenNothingIsSaid) {
  constexpr char kClean[] =
      R"({"robot":"arm","seed":1,"family":"clean","ratio_target":0,"twins":[],"effects":[]})";
  EXPECT_TRUE(score(kClean, R"({"mismatch":false,"status":"ABSENT"})").right);
  EXPECT_FALSE(score(kClean,
                     R"({"mismatch":true,"status":"CONFIRMED","findings":[{"effect":"backlash",)"
                     R"("where":["elbow"]}]})")
                   .right);
}

TEST_F(Reveal, DecoyNeedsItsName) {
  constexpr char kDecoy[] =
      R"({"robot":"arm","seed":1,"family":"decoy","ratio_target":0,"twins":[],"effects":[],
      "decoy":{"defect":"16-bit wrap","file":"rec_2.csv"}})";
  EXPECT_TRUE(score(kDecoy,
                    R"({"mismatch":false,"status":"REFUSED","refused":[{"file":"x/rec_2.csv",)"
                    R"("defect":"16-bit wrap"}]})")
                  .right);
  EXPECT_FALSE(score(kDecoy,
                     R"({"mismatch":false,"status":"REFUSED","refused":[{"file":"x/rec_2.csv",)"
                     R"("defect":"gap"}]})")
                   .right);
  EXPECT_FALSE(score(kDecoy,
                     R"({"mismatch":false,"status":"REFUSED","refused":[{"file":"x/rec_1.csv",)"
                     R"("defect":"16-bit wrap"}]})")
                   .right);
}

TEST_F(Reveal, OutsideNeedsUnnamedAndThePlace) {
  constexpr char kOutside[] =
      R"({"robot":"arm","seed":1,"family":"outside","ratio_target":10,"twins":[],"effects":[
      {"id":"cubic_spring","where":["elbow"],"parameters":{"size":1},"ratio":10}]})";
  EXPECT_TRUE(
      score(kOutside,
            R"({"mismatch":true,"status":"PRESENT_UNNAMED","unexplained":{"where":"elbow"}})")
          .right);
  EXPECT_FALSE(
      score(kOutside,
            R"({"mismatch":true,"status":"CONFIRMED","findings":[{"effect":"cable_spring",)"
            R"("where":["elbow"]}]})")
          .right);
}

TEST_F(Reveal, UnreadableVerdictIsAnError) {
  EXPECT_THROW(score(kBacklash, "nonsense"), plant::WorldError);
  EXPECT_THROW(score(kBacklash, R"({"status":"ABSENT"})"), plant::WorldError);
  EXPECT_THROW(reveal("/nonexistent", "x"), plant::WorldError);
}

}  // namespace
}  // namespace sanso::conceal
