// Runs that are ended by a signal leave an UNFINISHED verdict with what they had accepted. Each
// run ends in a process of its own: a stop request lasts as long as its process.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/noisy_world.h"
#include "tests/support/temp_folder.h"
#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/run/ending.h"
#include "tools/recording/csv_writer.h"

namespace sanso::diagnose {
namespace {

class EndedEarly : public testing::Test {
 protected:
  void SetUp() override {
    const ModelFolder model = test::pendulum(test::kNoisyServo);
    write_model_folder(model, (folder_ / "model").string());
    options_.model = (folder_ / "model").string();
    options_.out = (folder_ / "out").string();
    options_.quiet = true;
    const ModelFolder world =
        test::hiding(model, {test::hidden("coulomb_friction", "a", {{"coulomb", 0.3}})});
    for (const recording::Recording& r : test::recordings_of(world, 2, 4.0, 5)) {
      options_.recordings.push_back((folder_ / r.file).string());
      recording::write_csv(r, options_.recordings.back());
    }
    options_.effects = {"coulomb_friction", "viscous_friction", "rotor_inertia"};
  }
  nlohmann::json verdict() const {
    std::ifstream file(folder_ / "out" / "verdict.json");
    return nlohmann::json::parse(file);
  }
  bool written(const char* name) const { return std::filesystem::exists(folder_ / "out" / name); }

  /// The command, ended by SIGTERM when the method says a line that holds `words`.
  void end_at(const std::string& words) {
    SoFar so_far;
    const Method method{[&](const Progress&) -> Ending {
                          diagnose(
                              options_,
                              [&](const std::string& line) {
                                if (line.find(words) != std::string::npos) std::raise(SIGTERM);
                              },
                              &so_far);
                          return {};
                        },
                        [&](double seconds) {
                          Diagnosis d = so_far.diagnosis(seconds);
                          return Ending{std::move(d.verdict), std::move(d.patched), "text", "page"};
                        }};
    std::exit(run_command(options_, method));
  }
  sanso::test::TempFolder temporary_;
  std::filesystem::path folder_ = temporary_.path();
  DiagnoseOptions options_;
};

TEST_F(EndedEarly, WhatWasAcceptedIsWritten) {
  EXPECT_EXIT(end_at("asks: is anything missing beside 1 name"), testing::ExitedWithCode(2), "");
  const nlohmann::json v = verdict();
  EXPECT_EQ(v.at("status"), "UNFINISHED");
  EXPECT_EQ(v.at("mismatch"), true);
  ASSERT_EQ(v.at("findings").size(), 1U) << v.at("answer");
  const nlohmann::json& f = v.at("findings").at(0);
  EXPECT_EQ(f.at("effect"), "coulomb_friction");
  EXPECT_EQ(f.at("status"), "UNFINISHED") << "nothing that was not judged is confirmed";
  EXPECT_GT(f.at("parameters").at("coulomb").at("value").get<double>(), 0.1);
  EXPECT_GT(v.at("unfinished").at("removed").get<double>(), 0.5);
  EXPECT_TRUE(written("report.html") && written("verdict.txt") && written("model"));
  const ModelFolder patched = read_model_folder((folder_ / "out" / "model").string());
  EXPECT_TRUE(std::any_of(patched.effects.begin(), patched.effects.end(),
                          [](const EffectEntry& e) { return e.id == "coulomb_friction"; }));
}

TEST_F(EndedEarly, BeforeAnythingIsFoundItSaysSo) {
  EXPECT_EXIT(end_at("how did the joints move"), testing::ExitedWithCode(2), "");
  const nlohmann::json v = verdict();
  EXPECT_EQ(v.at("status"), "UNFINISHED");
  EXPECT_EQ(v.at("mismatch"), false);
  EXPECT_TRUE(v.at("findings").empty());
  EXPECT_FALSE(written("model")) << "nothing is patched";
  EXPECT_NE(v.at("summary").get<std::string>().find("how did the joints move"), std::string::npos);
}

}  // namespace
}  // namespace sanso::diagnose
