// Three processes on the real clock: pty, sockets, UDP. Events are checked, never how long
// something took.
//
// A machine that does not give these processes their time makes the controller see late replies,
// and it rightly takes them for faults. So a scenario that went wrong runs again when, and only
// when, witnesses of the clock saw the machine hold programs up; it is skipped with their figures
// when that happens every time.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "host/learn/session/session.h"
#include "host/link/udp_channel.h"
#include "host/motion/motion.h"
#include "tests/loop/support/clock_witness.h"
#include "tests/support/temp_folder.h"
#include "tools/sanso/emulated_processes.h"

namespace sanso::loop {
namespace {

namespace fs = std::filesystem;
using wire::SupervisorState;

/// Set once, seen by all threads and by child processes made later.
class SharedFlag {
 public:
  SharedFlag() {
    void* memory =
        mmap(nullptr, sizeof(Flag), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::runtime_error("no shared memory");
    flag_ = new (memory) Flag(false);
  }
  ~SharedFlag() { munmap(flag_, sizeof(Flag)); }
  SharedFlag(const SharedFlag&) = delete;
  SharedFlag& operator=(const SharedFlag&) = delete;
  void set() const { flag_->store(true); }
  bool is_set() const { return flag_->load(); }

 private:
  using Flag = std::atomic<bool>;
  static_assert(Flag::is_always_lock_free);
  Flag* flag_;
};

/// Emulator and controller as processes, and the motion of these tests.
struct Robot {
  cli::EmulatedProcesses processes;
  motion::Motion squat = motion::MotionLibrary().load("squat");
  std::vector<model::State> reference;
  SharedFlag trial_begins;  // before that the robot may slump and be put on its feet

  explicit Robot(const fs::path& folder) : processes("lab", 1, folder) {
    squat.primitives = learn::from_origin(squat.primitives);
    reference = learn::reference_of(squat.primitives);
  }
  double true_height() const {
    return nlohmann::json::parse(processes.tell(R"({"command": "truth"})"))
        .at("p_world_base")
        .at(2);
  }
  /// The trunk is well below its standing height: the squat is under way. False after a minute, or
  /// when `over`.
  bool wait_until_on_the_way_down(const std::function<bool()>& over) const {
    for (int i = 0; i < 1200 && !over(); ++i) {
      if (trial_begins.is_set() && true_height() < 0.23) return true;
      usleep(50'000);
    }
    return false;
  }
};

/// A host's end of the link.
struct Host {
  link::UdpChannel channel;
  link::MonotonicClock clock{channel};
  link::RobotLink robot;
  explicit Host(const cli::EmulatedProcesses& p)
      : channel(p.address()), robot(channel, clock, p.key()) {}

  /// The controller may still be starting.
  bool open() {
    const Nanoseconds give_up = clock.now() + 60 * kSecond;
    while (robot.open() != Status::ok)
      if (clock.now() > give_up) return false;
    return true;
  }
  bool wait_for(SupervisorState state, double seconds) {
    const Nanoseconds give_up = clock.now() + from_seconds(seconds);
    const auto seen = [&] { return robot.latest().state; };
    for (robot.poll(); seen() != state && seen() != SupervisorState::fault && clock.now() < give_up;
         robot.poll())
      robot.wait_observation(clock.now() + 50 * kMillisecond);
    return seen() == state;
  }
  /// A held-up machine can make the self-test miss replies: what a person would do is clear the
  /// fault and look again.
  void wait_until_idle() {
    constexpr int kLooks = 3;
    for (int look = 1; !wait_for(SupervisorState::idle, 20); ++look) {
      if (look == kLooks || robot.latest().state != SupervisorState::fault)
        throw std::runtime_error("not idle: " + state());
      (void)link::lower_and_clear(robot);
      const Nanoseconds end = clock.now() + 100 * kMillisecond;
      while (clock.now() < end) robot.wait_observation(end);
    }
  }
  std::string state() const {
    return "state " + std::to_string(static_cast<int>(robot.latest().state)) + ", fault " +
           std::to_string(robot.latest().fault);
  }
};

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

/// What is wrong with the outcome; empty: nothing.
using Finding = std::string;

/// What the machine did to the processes that excuses a wrong outcome.
std::optional<std::string> held_up(const ClockWitness& robot_side, const ClockWitness& host_side) {
  // half of what the controller waits for one reply
  constexpr Nanoseconds kRobotSide = 2 * kMillisecond;
  constexpr Nanoseconds kHostSide = 300 * kMillisecond;  // a tenth of the link's patience
  if (robot_side.worst() <= kRobotSide && host_side.worst() <= kHostSide) return std::nullopt;
  return "programs of the robot's priority were held up for " +
         std::to_string(robot_side.worst() / kMillisecond) + " ms, others for " +
         std::to_string(host_side.worst() / kMillisecond) + " ms";
}

/// Runs `scenario` on a fresh robot, again after an attempt that the machine spoiled.
void on_a_robot(const std::function<Finding(Robot&)>& scenario) {
  constexpr int kAttempts = 4, kPriorityOfTheEmulator = 40;
  std::string excuse;
  for (int attempt = 1; attempt <= kAttempts; ++attempt) {
    const test::TempFolder folder;
    const ClockWitness robot_side(kPriorityOfTheEmulator), host_side(0);
    Finding wrong;
    std::string log;
    try {
      Robot robot(folder.path());
      try {
        wrong = scenario(robot);
      } catch (const std::exception& error) {
        wrong = error.what();
      }
      log = robot.processes.firmware_log();
      ASSERT_NO_THROW(robot.processes.check())
          << "no machine is slow enough to excuse a program that ended\n"
          << wrong;
    } catch (const std::exception& error) {
      wrong = error.what();  // did not start
    }
    if (wrong.empty()) return;
    const auto reason = held_up(robot_side, host_side);
    ASSERT_TRUE(reason.has_value()) << wrong << "\nlog of the controller:\n" << log;
    excuse = *reason;
    std::printf("attempt %d: %s, but %s\n", attempt, wrong.c_str(), excuse.c_str());
  }
  GTEST_SKIP() << "SKIPPED: this machine gives no program its time: " << excuse;
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
