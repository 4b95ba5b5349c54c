#include "tools/sanso/emulated_access.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fstream>
#include <stdexcept>
#include <thread>

#include "host/learn/atomic_file.h"
#include "tools/emulator/control_client.h"
#include "tools/inprocess/truth_frame.h"

namespace sanso::cli {
namespace {

namespace fs = std::filesystem;
using wire::SupervisorState;

std::string hex(const wire::Key& key) {
  std::string out;
  for (std::uint8_t byte : key) out += fmt::format("{:02x}", byte);
  return out;
}

/// A UDP port of this machine that nobody uses now.
int free_port() {
  const int s = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  const bool ok = s >= 0 && ::bind(s, reinterpret_cast<sockaddr*>(&address), size) == 0 &&
                  ::getsockname(s, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  ::close(s);
  if (!ok) throw std::runtime_error("no free UDP port on 127.0.0.1");
  return ntohs(address.sin_port);
}

std::string last_lines(const fs::path& log) {
  std::ifstream in(log);
  std::string all((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  return all.size() > 600 ? all.substr(all.size() - 600) : all;
}

}  // namespace

EmulatedAccess::EmulatedAccess(const std::string& world, std::uint64_t seed, const fs::path& folder)
    : world_(world), folder_(folder), key_(wire::random_key()), port_(free_port()) {
  fs::create_directories(folder_);
  std::string name = (fs::temp_directory_path() / "sanso_robot_XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::runtime_error(name + ": cannot create");
  robot_directory_ = name;
  start_emulator(seed);
  start_firmware();
  channel_ = std::make_unique<link::UdpChannel>(fmt::format("127.0.0.1:{}", port_));
  clock_ = std::make_unique<link::MonotonicClock>(*channel_);
  link_ = std::make_unique<link::RobotLink>(*channel_, *clock_, key_);
  if (link_->open() != Status::ok)
    throw std::runtime_error("sanso-firmware does not answer:\n" + last_lines(firmware_->log()));
  truth_ = std::make_unique<TruthSampler>(robot_directory_);
}

EmulatedAccess::~EmulatedAccess() {
  truth_.reset();
  firmware_.reset();
  emulator_.reset();
  std::error_code ignored;
  fs::remove_all(robot_directory_, ignored);
}

void EmulatedAccess::start_emulator(std::uint64_t seed) {
  const fs::path config = folder_ / "emulator.toml";
  learn::write_atomically(config, fmt::format("world = \"{}\"\nseed = {}\ndirectory = \"{}\"\n", world_, seed % 1'000'000, robot_directory_));
  emulator_ = std::make_unique<ChildProcess>(find_program("sanso-emulator"), std::vector<std::string>{"--config", config.string()},
                                             folder_ / "emulator.log");
  for (int i = 0; i < 100 && emulator_->running(); ++i) {
    if (fs::exists(fs::path(robot_directory_) / "control")) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  throw std::runtime_error("sanso-emulator did not start:\n" + last_lines(emulator_->log()));
}

void EmulatedAccess::start_firmware() {
  const fs::path key_file = folder_ / "key.hex", config = folder_ / "firmware.toml";
  learn::write_atomically(key_file, hex(key_) + "\n");
  learn::write_atomically(config, fmt::format("[device]\nbus = \"{0}/bus\"\nimu = \"unix:{0}/imu\"\npose = \"unix:{0}/pose\"\n"
                                              "listen = \"127.0.0.1\"\nport = {1}\nkey_file = \"{2}\"\nlog_directory = \"{3}\"\n",
                                              robot_directory_, port_, fs::absolute(key_file).string(), fs::absolute(folder_).string()));
  firmware_ = std::make_unique<ChildProcess>(find_program("sanso-firmware"), std::vector<std::string>{"--config", config.string()},
                                             folder_ / "firmware.log");
}

void EmulatedAccess::tell(const std::string& json) { (void)emulator::tell_emulator(robot_directory_, json); }

void EmulatedAccess::check_children() {
  if (!emulator_->running()) throw std::runtime_error("sanso-emulator ended:\n" + last_lines(emulator_->log()));
  if (!firmware_->running()) throw std::runtime_error("sanso-firmware ended:\n" + last_lines(firmware_->log()));
}

void EmulatedAccess::wait_for(SupervisorState state, double patience_s, const char* what) {
  const Nanoseconds give_up = clock_->now() + from_seconds(patience_s);
  for (link_->poll(); link_->latest().state != state; link_->wait_observation(clock_->now() + 100 * kMillisecond)) {
    check_children();
    const bool fault = link_->latest().state == SupervisorState::fault && state != SupervisorState::fault;
    if (fault || clock_->now() >= give_up)
      throw std::runtime_error(fmt::format("{}: state {}, fault {} (docs/faults.md)", what, static_cast<int>(link_->latest().state),
                                           link_->latest().fault));
  }
}

/// Whatever the last trial left: lowered, or its fault cleared, torque off.
void EmulatedAccess::bring_to_idle() {
  link_->poll();
  const SupervisorState state = link_->latest().state;
  if (state == SupervisorState::fault) {
    (void)link_->command({.kind = wire::CommandKind::clear_fault});
    link_->wait_observation(clock_->now() + 100 * kMillisecond);
  } else if (state != SupervisorState::idle && state != SupervisorState::self_test && state != SupervisorState::boot) {
    (void)link_->command({.kind = wire::CommandKind::disarm});
  }
}

link::RobotLink& EmulatedAccess::place(const model::State& x, std::uint64_t) {
  check_children();
  bring_to_idle();
  constexpr double kLowerOrSelfTest_s = 20.0;
  wait_for(SupervisorState::idle, kLowerOrSelfTest_s, "getting ready for the next trial");
  std::string angles;
  for (int j = 0; j < model::kNumJoints; ++j) angles += fmt::format("{}{:.9f}", j > 0 ? ", " : "", x[model::kXJoint + j]);
  tell(fmt::format(R"({{"command": "place", "leg_angles": [{}], "held": true}})", angles));
  constexpr Nanoseconds kSettle = 300 * kMillisecond;  // the estimator sees where it is now
  for (const Nanoseconds end = clock_->now() + kSettle; clock_->now() < end;) link_->wait_observation(end);
  (void)truth_->take();
  return *link_;
}

void EmulatedAccess::add_measurements(learn::Episode& episode) {
  const std::vector<TruthSampler::Sample> seen = truth_->take();
  if (episode.ticks.empty() || seen.empty()) return;
  std::size_t k = 0;
  const auto nearest = [&](Nanoseconds time) {  // both ascend in time
    while (k + 1 < seen.size() && std::abs(seen[k + 1].time - time) <= std::abs(seen[k].time - time)) ++k;
    return seen[k];
  };
  const inprocess::TruthFrame frame(nearest(episode.ticks.front().time).leg_state, episode.reference.front());
  for (const wire::Observation& o : episode.ticks) {
    const TruthSampler::Sample sample = nearest(o.time);
    episode.truth.push_back(frame.sample(sample.leg_state, sample.foot_load_N));
  }
}

}  // namespace sanso::cli
