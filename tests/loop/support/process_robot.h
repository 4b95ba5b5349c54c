// Controller and emulator as processes on the real clock, a host for them, and a scenario on them
// that is run again when the machine spoiled it.
//
// A machine that does not give these processes their time makes the controller see late replies,
// and it rightly takes them for faults. So a scenario that went wrong runs again when, and only
// when, witnesses of the clock saw the machine hold programs up; it is skipped with their figures
// when that happens every time.
#pragma once

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/learn/session/session.h"
#include "host/link/udp_channel.h"
#include "host/motion/motion.h"
#include "tests/loop/support/clock_witness.h"
#include "tests/support/temp_folder.h"
#include "tools/sanso/emulated_processes.h"

namespace sanso::loop {

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

/// What is wrong with the outcome; empty: nothing.
using Finding = std::string;

/// What the machine did to the processes that excuses a wrong outcome.
inline std::optional<std::string> held_up(const ClockWitness& robot_side,
                                          const ClockWitness& host_side) {
  // half of what the controller waits for one reply
  constexpr Nanoseconds kRobotSide = 2 * kMillisecond;
  constexpr Nanoseconds kHostSide = 300 * kMillisecond;  // a tenth of the link's patience
  if (robot_side.worst() <= kRobotSide && host_side.worst() <= kHostSide) return std::nullopt;
  return "programs of the robot's priority were held up for " +
         std::to_string(robot_side.worst() / kMillisecond) + " ms, others for " +
         std::to_string(host_side.worst() / kMillisecond) + " ms";
}

/// Runs `scenario` on a fresh robot, again after an attempt that the machine spoiled.
inline void on_a_robot(const std::function<Finding(Robot&)>& scenario) {
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

}  // namespace sanso::loop
