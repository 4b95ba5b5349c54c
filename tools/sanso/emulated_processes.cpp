// Writes configurations and key into the session's folder, starts both programs, and shows their
// last lines when one dies.
#include "tools/sanso/emulated_processes.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <thread>

#include "shared/files/atomic_file.h"
#include "tools/emulator/control_client.h"

namespace sanso::cli {
namespace {

namespace fs = std::filesystem;

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

}  // namespace

EmulatedProcesses::EmulatedProcesses(const std::string& world, std::uint64_t seed,
                                     const fs::path& folder)
    : folder_(folder), key_(wire::random_key()), port_(free_port()) {
  fs::create_directories(folder_);
  std::string name = (fs::temp_directory_path() / "sanso_robot_XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::runtime_error(name + ": cannot create");
  robot_directory_ = name;
  start_emulator(world, seed);
  start_firmware();
}

EmulatedProcesses::~EmulatedProcesses() {
  firmware_.reset();
  emulator_.reset();
  std::error_code ignored;
  fs::remove_all(robot_directory_, ignored);
}

std::string EmulatedProcesses::address() const { return fmt::format("127.0.0.1:{}", port_); }
std::string EmulatedProcesses::firmware_log() const { return firmware_->last_words(); }
std::string EmulatedProcesses::tell(const std::string& json) const {
  return emulator::tell_emulator(robot_directory_, json);
}

void EmulatedProcesses::put_on_feet(const model::State& x) const {
  std::string angles;
  for (int j = 0; j < model::kNumJoints; ++j)
    angles += fmt::format("{}{:.9f}", j > 0 ? ", " : "", x[model::kXJoint + j]);
  (void)tell(fmt::format(R"({{"command": "place", "leg_angles": [{}], "held": true}})", angles));
}

void EmulatedProcesses::check() {
  if (!emulator_->running())
    throw std::runtime_error("sanso-emulator ended:\n" + emulator_->last_words());
  if (!firmware_->running())
    throw std::runtime_error("sanso-firmware ended:\n" + firmware_->last_words());
}

void EmulatedProcesses::signal_firmware(int signal) const { ::kill(firmware_->pid(), signal); }

bool EmulatedProcesses::firmware_ends(double within_s) {
  constexpr auto kLook = std::chrono::milliseconds(10);
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::duration<double>(within_s);
  while (firmware_->running()) {
    if (std::chrono::steady_clock::now() > give_up) return false;
    std::this_thread::sleep_for(kLook);
  }
  return true;
}

void EmulatedProcesses::restart_firmware() {
  firmware_.reset();
  start_firmware();
}

void EmulatedProcesses::start_emulator(const std::string& world, std::uint64_t seed) {
  const fs::path config = folder_ / "emulator.toml";
  files::write_atomically(config, fmt::format("world = \"{}\"\nseed = {}\ndirectory = \"{}\"\n",
                                              world, seed % 1'000'000, robot_directory_));
  emulator_ = std::make_unique<ChildProcess>(find_program("sanso-emulator"),
                                             std::vector<std::string>{"--config", config.string()},
                                             folder_ / "emulator.log");
  for (int i = 0; i < 600 && emulator_->running();
       ++i) {  // half a minute: a crowded machine starts programs slowly
    if (fs::exists(fs::path(robot_directory_) / "control")) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  throw std::runtime_error("sanso-emulator did not start:\n" + emulator_->last_words());
}

void EmulatedProcesses::start_firmware() {
  const fs::path key_file = folder_ / "key.hex", config = folder_ / "firmware.toml";
  files::write_atomically(key_file, hex(key_) + "\n");
  fs::permissions(key_file, fs::perms::owner_read | fs::perms::owner_write);
  files::write_atomically(
      config,
      fmt::format(
          "[device]\nbus = \"{0}/bus\"\nimu = \"unix:{0}/imu\"\npose = \"unix:{0}/pose\"\n"
          "listen = \"127.0.0.1\"\nport = {1}\nkey_file = \"{2}\"\nlog_directory = \"{3}\"\n"
          "allow_without_realtime = true\n",  // nobody is hurt
          robot_directory_, port_, fs::absolute(key_file).string(),
          fs::absolute(folder_).string()));
  firmware_ = std::make_unique<ChildProcess>(find_program("sanso-firmware"),
                                             std::vector<std::string>{"--config", config.string()},
                                             folder_ / "firmware.log");
}

}  // namespace sanso::cli
