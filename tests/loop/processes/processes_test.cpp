// Three processes on the real clock: pty, sockets, UDP. Events are checked, never how long
// something took.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <thread>

#include "tests/loop/support/process_robot.h"

namespace sanso::loop {
namespace {

learn::Episode squat_once(Host& host, const Robot& robot) {
  learn::TrialSetup setup;
  setup.primitives = &robot.squat.primitives;
  setup.reference = robot.reference;
  setup.weights = robot.squat.weights;
  setup.layers.middle = false;
  setup.duration_ticks = robot.squat.primitives.duration_ticks();
  mpc::UpperLayer upper(mpc::MpcSettings{}, host::AugmentedModel{});
  host.wait_until_idle();
  robot.processes.put_on_feet(robot.reference.front());
  host.clock.wait_until(host.clock.now() + 300 * kMillisecond);
  learn::prepare_trial(host.robot, setup, {});
  robot.trial_begins.set();
  return learn::run_trial(host.robot, upper, setup, {});
}

/// In a child process: a host that squats, then waits for its end.
[[noreturn]] void be_the_host(const Robot& robot) {
  try {
    Host host(robot.processes);
    if (!host.open()) _exit(1);
    (void)squat_once(host, robot);
    while (true) pause();  // however late the killer comes
  } catch (const std::exception& error) {
    std::fprintf(stderr, "host: %s\n", error.what());
  }
  _exit(2);
}

Finding kill_the_host(Robot& robot, int after_ms) {
  const pid_t host = fork();
  if (host == 0) be_the_host(robot);
  int status = 0;
  bool ended = false;
  const bool down = robot.wait_until_on_the_way_down(
      [&] { return ended = ended || waitpid(host, &status, WNOHANG) == host; });
  if (down) usleep(static_cast<useconds_t>(after_ms) * 1000);
  if (!ended) {
    kill(host, SIGKILL);
    waitpid(host, &status, 0);
  }
  if (!down)
    return ended ? "the host ended by itself, status " + std::to_string(status)
                 : "the squat did not begin";
  if (!WIFSIGNALED(status))
    return "the host ended before it was killed, status " + std::to_string(status);

  Host witness(robot.processes);
  if (!witness.open()) return "a new host does not find the controller";
  if (!witness.wait_for(SupervisorState::hold, 6)) return "no hold: " + witness.state();
  if (witness.robot.latest().fault != 0) return "a fault: " + witness.state();
  if (robot.true_height() <= 0.2)
    return "not on its feet: trunk at " + std::to_string(robot.true_height()) + " m";
  return {};
}

class HostKilled : public testing::TestWithParam<int> {};

TEST_P(HostKilled, InMidSquatLeavesTheRobotInHoldOnItsFeet) {
  on_a_robot([](Robot& robot) { return kill_the_host(robot, GetParam()); });
}

INSTANTIATE_TEST_SUITE_P(AfterGoingDownFor, HostKilled, testing::Values(0, 600, 1200, 1800),
                         [](const auto& p) { return std::to_string(p.param) + "ms"; });

Finding pull_the_pty(Robot& robot) {
  Host host(robot.processes);
  if (!host.open()) return "the controller does not answer";
  std::atomic<bool> trial_over{false}, pulled{false};
  std::thread puller([&] {
    try {
      if (!robot.wait_until_on_the_way_down([&] { return trial_over.load(); })) return;
      (void)robot.processes.tell(R"({"command": "unplug_bus"})");
      pulled = true;
    } catch (const std::exception& error) {
      std::fprintf(stderr, "puller: %s\n", error.what());
    }
  });
  Finding wrong;
  try {
    const learn::Episode episode = squat_once(host, robot);
    if (episode.end != learn::TrialEnd::completed && episode.end != learn::TrialEnd::fault)
      wrong = std::string("the trial ended with ") + learn::to_string(episode.end);
  } catch (const std::exception& error) {
    wrong = error.what();
  }
  trial_over = true;
  puller.join();
  if (!wrong.empty()) return wrong;
  if (!pulled) return "the squat did not begin";
  if (!host.wait_for(SupervisorState::fault, 5)) return "no fault: " + host.state();
  if (host.robot.latest().fault != 12) return "another fault: " + host.state();
  if (robot.true_height() <= 0.12) return "the servos did not hold their last goal";
  return {};
}

TEST(PulledPty, IsFaultBusGone) { on_a_robot(pull_the_pty); }

}  // namespace
}  // namespace sanso::loop
