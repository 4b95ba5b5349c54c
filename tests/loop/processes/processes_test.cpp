// Three processes on the real clock: pty, sockets, UDP. Events are checked, never how long something took.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/learn/session.h"
#include "host/link/udp_channel.h"
#include "host/motion/motion.h"
#include "tools/sanso/emulated_processes.h"

namespace sanso::loop {
namespace {

namespace fs = std::filesystem;
using wire::SupervisorState;

struct Processes : testing::Test {
  fs::path folder;
  std::unique_ptr<cli::EmulatedProcesses> processes;
  motion::Motion squat = motion::MotionLibrary().load("squat");
  std::vector<model::State> reference;

  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "sanso_processes_XXXXXX").string();
    folder = mkdtemp(name.data());
    processes = std::make_unique<cli::EmulatedProcesses>("lab", 1, folder);
    squat.primitives = learn::from_origin(squat.primitives);
    reference = learn::reference_of(squat.primitives);
  }
  void TearDown() override {
    processes.reset();
    fs::remove_all(folder);
  }
  double true_height() const {
    return nlohmann::json::parse(processes->tell(R"({"command": "truth"})")).at("p_world_base").at(2);
  }
  /// The trunk is well below its standing height: the squat is under way. False after a minute.
  bool wait_until_on_the_way_down() const {
    bool stood = false;  // it is put on its feet first
    for (int i = 0; i < 1200; ++i) {
      const double z = true_height();
      stood = stood || z > 0.26;
      if (stood && z < 0.23) return true;
      usleep(50'000);
    }
    return false;
  }
};

/// A host: link, planner and one squat.
struct Host {
  link::UdpChannel channel;
  link::MonotonicClock clock{channel};
  link::RobotLink robot;
  Host(const cli::EmulatedProcesses& p) : channel(p.address()), robot(channel, clock, p.key()) {}

  bool wait_for(SupervisorState state, double seconds) {
    const Nanoseconds give_up = clock.now() + from_seconds(seconds);
    for (robot.poll(); robot.latest().state != state && clock.now() < give_up; robot.poll())
      robot.wait_observation(clock.now() + 50 * kMillisecond);
    return robot.latest().state == state;
  }
};

learn::Episode squat_once(Host& host, const motion::Motion& motion, const std::vector<model::State>& reference,
                          const cli::EmulatedProcesses& processes) {
  learn::TrialSetup setup;
  setup.primitives = &motion.primitives;
  setup.reference = reference;
  setup.weights = motion.weights;
  setup.layers.middle = false;
  setup.duration_ticks = motion.primitives.duration_ticks();
  mpc::UpperLayer upper(mpc::MpcSettings{}, host::AugmentedModel{});
  if (!host.wait_for(SupervisorState::idle, 20))
    throw std::runtime_error("not idle: state " + std::to_string(static_cast<int>(host.robot.latest().state)) + ", fault " +
                             std::to_string(host.robot.latest().fault) + "\n" + processes.firmware_log());
  processes.put_on_feet(reference.front());
  host.clock.wait_until(host.clock.now() + 300 * kMillisecond);
  learn::prepare_trial(host.robot, setup, {});
  return learn::run_trial(host.robot, upper, setup, {});
}

class HostKilled : public Processes, public testing::WithParamInterface<int> {};

TEST_P(HostKilled, InMidSquatLeavesTheRobotInHoldOnItsFeet) {
  const pid_t host = fork();
  if (host == 0) {
    try {
      Host h(*processes);
      if (h.robot.open() != Status::ok) _exit(1);
      (void)squat_once(h, squat, reference, *processes);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "host: %s\n", error.what());
      _exit(2);
    }
    _exit(0);
  }
  ASSERT_TRUE(wait_until_on_the_way_down());
  usleep(static_cast<useconds_t>(GetParam()) * 1000);
  kill(host, SIGKILL);
  int status = 0;
  waitpid(host, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));

  Host witness(*processes);
  ASSERT_EQ(witness.robot.open(), Status::ok) << "a new host finds the controller";
  EXPECT_TRUE(witness.wait_for(SupervisorState::hold, 6)) << "state " << static_cast<int>(witness.robot.latest().state);
  EXPECT_EQ(witness.robot.latest().fault, 0);
  EXPECT_GT(true_height(), 0.2);
}

INSTANTIATE_TEST_SUITE_P(AfterGoingDownFor, HostKilled, testing::Values(0, 600, 1200, 1800),
                         [](const auto& p) { return std::to_string(p.param) + "ms"; });

TEST_F(Processes, APulledPtyIsFaultBusGone) {
  Host host(*processes);
  ASSERT_EQ(host.robot.open(), Status::ok);
  std::thread puller([&] {
    (void)wait_until_on_the_way_down();
    (void)processes->tell(R"({"command": "unplug_bus"})");
  });
  EXPECT_NO_THROW({
    const learn::Episode episode = squat_once(host, squat, reference, *processes);
    if (episode.end != learn::TrialEnd::completed) {
      EXPECT_EQ(episode.end, learn::TrialEnd::fault);
    }
  });
  puller.join();
  EXPECT_TRUE(host.wait_for(SupervisorState::fault, 5));
  EXPECT_EQ(host.robot.latest().fault, 12);
  EXPECT_GT(true_height(), 0.12) << "the servos hold their last goal";
}

}  // namespace
}  // namespace sanso::loop
