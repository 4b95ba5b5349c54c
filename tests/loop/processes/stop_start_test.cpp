// The controller's program is ended in every way there is, in the middle of what the robot does,
// and started again: nobody falls, no torque goes that nobody asked to go, and SIGTERM ends with
// the robot lowered.
//
// SANSO_STOP_START_RUNS: runs of each of the nine cases (default 1; 100 is the whole campaign).
// SANSO_STOP_START_FIRST: number of the first of them (default 0), to go on with a campaign.
// SANSO_STOP_START_ROBOTS: robots at a time (default 2).
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <random>
#include <thread>

#include "tests/loop/support/process_robot.h"

namespace sanso::loop {
namespace {

enum class Situation { hold, squat, soft_stop };
struct Case {
  const char* name;
  int signal;
  Situation situation;
};

/// What the physics says, 50 times a second.
struct Truth {
  double height_m = 0, tilt_rad = 0;
  int other_contacts = 0, torques_on = 0;
};
Truth truth_of(const Robot& robot) {
  const auto t = nlohmann::json::parse(robot.processes.tell(R"({"command": "truth"})"));
  const auto q = t.at("quat_world_base").get<std::array<double, 4>>();
  const auto on = t.at("torque_on").get<std::array<bool, 20>>();
  return {t.at("p_world_base").at(2),
          std::acos(std::clamp(1.0 - 2.0 * (q[1] * q[1] + q[2] * q[2]), -1.0, 1.0)),
          t.at("other_contacts"), static_cast<int>(std::count(on.begin(), on.end(), true))};
}

/// Looks on until it is told to end, and keeps the worst.
class Onlooker {
 public:
  explicit Onlooker(const Robot& robot) : robot_(robot), thread_([this] { look(); }) {}
  ~Onlooker() {
    stop_ = true;
    thread_.join();
  }
  Finding finding() const {
    const std::lock_guard lock(mutex_);
    return finding_;
  }
  /// From now on torque may be off: it was asked for.
  void torque_may_go() { torque_may_go_ = true; }

 private:
  void look() {
    while (!stop_) {
      usleep(20'000);
      try {
        judge(truth_of(robot_));
      } catch (const std::exception&) {  // a busy emulator answers next time
      }
    }
  }
  void judge(const Truth& truth) {
    const std::lock_guard lock(mutex_);
    if (!finding_.empty()) return;
    const bool released = truth.torques_on == 0 && torque_may_go_;
    if (!released && (truth.other_contacts > 0 || truth.tilt_rad > 0.9))
      finding_ = "fell: tilt " + std::to_string(truth.tilt_rad) + " rad";
    else if (truth.torques_on < 20 && !torque_may_go_)
      finding_ = "torque went: " + std::to_string(truth.torques_on) + " of 20 servos have it";
  }
  const Robot& robot_;
  std::atomic<bool> stop_{false}, torque_may_go_{false};
  mutable std::mutex mutex_;
  Finding finding_;
  std::thread thread_;
};

void live(Host& host, double seconds) {
  const Nanoseconds end = host.clock.now() + from_seconds(seconds);
  while (host.clock.now() < end) {
    host.robot.wait_observation(std::min(end, host.clock.now() + 50 * kMillisecond));
    host.robot.send_sign_of_life();
  }
}

/// Into the middle of what the robot is to be doing.
void bring_into(Situation situation, Host& host, const Robot& robot, std::mt19937& random) {
  learn::TrialSetup setup;
  setup.primitives = &robot.squat.primitives;
  setup.reference = robot.reference;
  setup.layers.middle = setup.layers.upper = false;
  setup.duration_ticks = robot.squat.primitives.duration_ticks();
  learn::TrialSettings settings;
  settings.settle_s = 0.5;
  host.wait_until_idle();
  robot.processes.put_on_feet(robot.reference.front());
  live(host, 0.3);
  learn::prepare_trial(host.robot, setup, settings);
  const auto up_to = [&](double s) { return std::uniform_real_distribution<>(0.0, s)(random); };
  if (situation == Situation::hold) return live(host, up_to(1.0));
  wire::Command start{.kind = wire::CommandKind::start_trial,
                      .trial_id = setup.trial_id,
                      .layers = policy::LayerSwitches::kLower};
  start.duration_ticks = setup.duration_ticks;
  if (host.robot.command(start) != Status::ok) throw std::runtime_error("no trial");
  live(host, 0.5 + up_to(4.0));
  if (situation == Situation::squat) return;
  if (host.robot.command({.kind = wire::CommandKind::stop}) != Status::ok)
    throw std::runtime_error("no stop");
  live(host, up_to(1.0));
}

Finding end_and_start(Robot& robot, const Case& which, std::mt19937& random,
                      double longest_pause_s) {
  const double pause_s = std::uniform_real_distribution<>(0.2, longest_pause_s)(random);
  {
    Host host(robot.processes);
    if (!host.open()) return "the controller does not answer";
    bring_into(which.situation, host, robot, random);
  }
  Onlooker onlooker(robot);
  const bool lowers = which.signal == SIGTERM;
  if (lowers) onlooker.torque_may_go();
  robot.processes.signal_firmware(which.signal);
  if (!robot.processes.firmware_ends(20)) return "the program does not end";
  if (lowers) {
    const Truth down = truth_of(robot);
    if (down.torques_on > 0) return "ended with torque on";
    if (down.height_m > 0.19 || down.tilt_rad > 0.5)
      return "not lowered: trunk at " + std::to_string(down.height_m) + " m";
  }
  usleep(static_cast<useconds_t>(1e6 * pause_s));
  robot.processes.restart_firmware();
  Host host(robot.processes);
  if (!host.open()) return "a new controller does not answer";
  if (!host.wait_for(lowers ? SupervisorState::idle : SupervisorState::hold, 20))
    return "after the restart: " + host.state();
  live(host, 1.0);
  return onlooker.finding();
}

constexpr Case kCases[] = {{"TERM in hold", SIGTERM, Situation::hold},
                           {"TERM in a squat", SIGTERM, Situation::squat},
                           {"TERM in a soft stop", SIGTERM, Situation::soft_stop},
                           {"KILL in hold", SIGKILL, Situation::hold},
                           {"KILL in a squat", SIGKILL, Situation::squat},
                           {"KILL in a soft stop", SIGKILL, Situation::soft_stop},
                           {"abort in hold", SIGABRT, Situation::hold},
                           {"abort in a squat", SIGABRT, Situation::squat},
                           {"abort in a soft stop", SIGABRT, Situation::soft_stop}};

int number_from(const char* variable, int otherwise, int least) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::max(least, std::atoi(text)) : otherwise;
}

TEST(StopStart, NobodyFallsAndNoTorqueGoesThatNobodyAskedToGo) {
  const int runs = number_from("SANSO_STOP_START_RUNS", 1, 1);
  const int robots = number_from("SANSO_STOP_START_ROBOTS", 2, 1);
  const int first = number_from("SANSO_STOP_START_FIRST", 0, 0);
  const int jobs = runs * static_cast<int>(std::size(kCases));
  const double longest_pause_s = runs > 1 ? 5.0 : 1.0;
  std::atomic<int> next{0}, done{0};
  const auto work = [&] {
    for (int job = next++; job < jobs; job = next++) {
      const Case& which = kCases[job % static_cast<int>(std::size(kCases))];
      const int run = first + job / static_cast<int>(std::size(kCases));
      SCOPED_TRACE(std::string(which.name) + ", run " + std::to_string(run));
      on_a_robot([&](Robot& robot) {
        std::mt19937 random(static_cast<unsigned>(run));
        return end_and_start(robot, which, random, longest_pause_s);
      });
      std::printf("%d of %d: %s, run %d\n", ++done, jobs, which.name, run);
      std::fflush(stdout);
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < robots; ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace sanso::loop
