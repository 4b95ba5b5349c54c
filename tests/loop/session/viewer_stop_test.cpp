// A viewer's emergency stop that meets the robot before a trial, or in the poses of the bring-up:
// the session pauses, does again what was stopped, and learns what it would have learned.
#include "host/learn/session/bring_up.h"
#include "host/learn/session/watcher.h"
#include "tests/loop/support/loop_fixture.h"
#include "tests/support/temp_folder.h"

namespace sanso::loop {
namespace {

using wire::SupervisorState;

/// Presses the stop once, `ticks` into a state of the robot that is placed as number `robot`.
struct Press {
  int robot = 1;
  SupervisorState state = SupervisorState::hold;
  int ticks = 0;
};

/// Where a press meets what: the bring-up has the first robot, trial 1 the second.
const Press kArming{1, SupervisorState::stand_up, 5}, kPoses{1, SupervisorState::hold, 150},
    kBeforeTrial{2, SupervisorState::stand_up, 5}, kSettling{2, SupervisorState::hold, 5};

/// A person at a page: knows that the stop was pressed, as tools/page does.
struct Viewer : learn::SessionWatcher {
  bool pressed = false;
  void session_begins(const std::string&, int, const std::vector<learn::TrialSummary>&) override {}
  void trial_begins(const learn::TrialSetup&) override {}
  void planned(double) override {}
  void judged(double) override {}
  void trial_ended(const learn::TrialSummary&) override { pressed = false; }
  bool ends_session() override { return false; }
  bool stopped_by_viewer() override { return std::exchange(pressed, false); }
};

struct ViewerStop : testing::TestWithParam<Press> {
  /// A session of two trials. What happened, in order: "placed", "stopped", "may it go on?".
  void run(const std::string& name, const Press* press, learn::SessionWatcher* watcher) {
    const motion::Motion stand = motion::MotionLibrary().load("stand");
    inprocess::InProcessAccess access("nominal");
    access.on_new_robot([&](inprocess::InProcessRobot& made) {
      log.emplace_back("placed");
      ++robots;
      made.after_tick([&, press] { stop_there(made, press); });
    });
    mpc::UpperLayer upper(mpc::MpcSettings{}, host::AugmentedModel{});
    learn::SessionSettings settings;
    settings.iterations = 2;
    settings.out = temporary.path() / name;
    settings.trial.settle_s = 0.2;
    settings.trial.watcher = watcher;
    settings.bring_up.hold_s = 0.2;
    settings.bring_up.measure_s = 0.1;
    learn::Session session({"stand", stand.primitives, stand.weights, {}}, settings, access, upper);
    const auto asked = [&] {
      log.emplace_back("may it go on?");
      return false;
    };
    session.run([](const learn::TrialSummary&) {}, asked);
    learned = learn::learned_digest(session.state());
  }

  void stop_there(inprocess::InProcessRobot& robot, const Press* press) {
    if (!press || robots != press->robot || viewer.pressed || done) return;
    if (robot.controller().observation().state == press->state) ++ticks;
    if (ticks <= press->ticks) return;
    robot.handover().emergency_stop = true;
    log.emplace_back("stopped");
    viewer.pressed = done = true;
  }

  test::TempFolder temporary;
  Viewer viewer;
  std::vector<std::string> log;
  std::uint64_t learned = 0;
  int robots = 0, ticks = 0;
  bool done = false;
};

TEST_P(ViewerStop, PausesAndTheSameIsDoneAgain) {
  struct Undisturbed {
    std::uint64_t learned;
    std::ptrdiff_t placed;
  };
  static const Undisturbed undisturbed = [this] {
    run("undisturbed", nullptr, nullptr);
    return Undisturbed{learned, std::count(log.begin(), log.end(), "placed")};
  }();
  log.clear(), robots = 0;

  const Press press = GetParam();
  run("stopped", &press, &viewer);
  const auto stop = std::find(log.begin(), log.end(), "stopped");
  ASSERT_NE(stop, log.end()) << "the stop never met its robot";
  ASSERT_NE(stop + 1, log.end());
  EXPECT_EQ(*(stop + 1), "may it go on?") << "a robot moves again before anybody was asked";
  EXPECT_EQ(std::count(log.begin(), log.end(), "placed"), undisturbed.placed + 1);
  EXPECT_EQ(learned, undisturbed.learned);
}

TEST_P(ViewerStop, OfNobodyWhoWatchesEndsTheSession) {
  const Press press = GetParam();
  EXPECT_THROW(run("alone", &press, nullptr), learn::StoppedBefore);
  EXPECT_EQ(log.back(), "stopped") << "no robot moves after it";
}

INSTANTIATE_TEST_SUITE_P(Before, ViewerStop,
                         testing::Values(kArming, kPoses, kBeforeTrial, kSettling));

}  // namespace
}  // namespace sanso::loop
