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

/// What a hand was asked for, trial by trial.
TEST(Skating, TheHandThatTravelsAlongFadesEvenly) {
  struct Noted : inprocess::InProcessAccess {
    Noted(const app::LearnOptions& o, std::vector<double>& seen)
        : InProcessAccess(o.world, inprocess::settings_on(o.wheels, o.ground)), holds(seen) {}
    void lend_hand(const learn::Push& push) override {
      holds.push_back(push.hold);
      InProcessAccess::lend_hand(push);
    }
    std::vector<double>& holds;
  };
  const test::TempFolder folder;
  std::vector<double> holds;
  app::LearnOptions options;
  options.motion = "skate_ramp";
  options.iterations = 3;
  options.out = folder.path() / "run";
  options.threads = 1;
  options.quiet = true;
  options.set = {"session.hand_fades_over=2"};
  app::learn(options, [&](const app::LearnOptions& prepared) {
    return std::make_unique<Noted>(prepared, holds);
  });
  EXPECT_EQ(holds, (std::vector<double>{1.0, 0.5, 0.0}));
}

/// In `back` the first trial is a fall (docs/results/skating.md).
TEST(Skating, AHandKeepsTheRobotUpThatWouldFall) {
  const auto first_trial = [](const char* fades_over) {
    const test::TempFolder folder;
    app::LearnOptions options;
    options.motion = "skate_ramp";
    options.world = "back";
    options.iterations = 1;
    options.out = folder.path() / "run";
    options.threads = 1;
    options.quiet = true;
    options.set = {std::string("session.hand_fades_over=") + fades_over};
    app::learn(options, [](const app::LearnOptions& prepared) {
      return std::make_unique<inprocess::InProcessAccess>(
          prepared.world, inprocess::settings_on(prepared.wheels, prepared.ground));
    });
    return learn::load_episode(options.out / "trial_0000.episode").failed();
  };
  EXPECT_TRUE(first_trial("0"));
  EXPECT_FALSE(first_trial("10"));
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
