// `sanso learn` on wheels, whole: the motion's ground and feet reach planner, controller and
// emulated robot, a hand starts it, it arrives, and a session goes on with the same bits.
#include <nlohmann/json.hpp>

#include "host/app/learn_command.h"
#include "shared/files/atomic_file.h"
#include "tests/loop/support/loop_fixture.h"
#include "tests/support/temp_folder.h"

namespace sanso::loop {
namespace {

namespace fs = std::filesystem;

/// Exit code of so many trials down the ramp in `out`.
int roll_down(const fs::path& out, int iterations, bool resume = false) {
  app::LearnOptions options;
  options.motion = "skate_ramp";
  options.iterations = iterations;
  options.out = out;
  options.resume = resume;
  options.threads = 1;
  options.quiet = true;
  return app::learn(options, [](const app::LearnOptions& prepared) {
    return std::make_unique<inprocess::InProcessAccess>(
        prepared.world, inprocess::settings_on(prepared.wheels, prepared.ground));
  });
}

nlohmann::json summary_of(const fs::path& out) {
  return nlohmann::json::parse(files::read_text(out / "summary.json"));
}

TEST(Skating, ArrivesUprightAtTheRunOut) {
  const test::TempFolder folder;
  EXPECT_EQ(roll_down(folder.path() / "run", 1), 0);
  const nlohmann::json summary = summary_of(folder.path() / "run");
  EXPECT_EQ(summary["world"], "lab+ramp+wheels");
  const learn::Episode episode = learn::load_episode(folder.path() / "run" / "trial_0000.episode");
  const model::State& last = episode.truth.back().x;
  EXPECT_GT(last[0], 1.31);                  // half a metre along the run-out
  EXPECT_NEAR(last[2], 0.181, 0.01);         // 0.10 m lower than it began
  EXPECT_GT(last[model::kXVel], 1.0);        // what 0.10 m give is 1.4 m/s
  EXPECT_EQ(episode.truth.front().x[0], 0);  // and it began at rest
  EXPECT_LT(std::abs(episode.truth.front().x[model::kXVel]), 0.02);
}

TEST(Skating, ASessionGoesOnWithTheSameBits) {
  const test::TempFolder folder;
  roll_down(folder.path() / "parts", 1);
  roll_down(folder.path() / "parts", 2, true);
  roll_down(folder.path() / "whole", 2);
  EXPECT_EQ(summary_of(folder.path() / "parts")["learned_digest"],
            summary_of(folder.path() / "whole")["learned_digest"]);
}

TEST(Skating, ARobotWithoutAHandSaysSo) {
  struct Handless : inprocess::InProcessAccess {
    using InProcessAccess::InProcessAccess;
    void lend_hand(const learn::Push& push) override { RobotAccess::lend_hand(push); }
  };
  const test::TempFolder folder;
  app::LearnOptions options;
  options.motion = "skate_ramp";
  options.iterations = 1;
  options.out = folder.path() / "run";
  options.quiet = true;
  try {
    app::learn(options, [](const app::LearnOptions& prepared) {
      return std::make_unique<Handless>(prepared.world);
    });
    FAIL() << "it would have rolled away";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("hand"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace sanso::loop
