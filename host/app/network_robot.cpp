// Waits for idle, asks the person at the terminal, and never places the robot itself.
#include "host/app/network_robot.h"

#include <fmt/format.h>

#include <stdexcept>

#include "shared/files/atomic_file.h"
#include "shared/files/input_error.h"

namespace sanso::app {
namespace {

using wire::SupervisorState;

/// Why a controller may be there and yet say nothing.
std::string who_answers(const std::optional<wire::Identity>& identity) {
  if (!identity) return "is sanso-firmware running there, is the port open?";
  const std::string name(identity->robot_name.data());
  if (identity->protocol_version != wire::kProtocolVersion)
    return fmt::format("robot '{}' is there and speaks version {} of the protocol, this host {}",
                       name, identity->protocol_version, wire::kProtocolVersion);
  return fmt::format("robot '{}' is there: is the key the same?", name);
}

}  // namespace

wire::Key read_key(const std::filesystem::path& file) {
  std::string text;
  try {
    text = files::read_text(file);
  } catch (const files::InputError& error) {
    throw std::runtime_error(fmt::format("--key {}", error.what()));
  }
  const Result<wire::Key> key = wire::key_from_hex(text);
  if (!key.ok())
    throw std::runtime_error(
        "--key " + file.string() +
        ": expected a file of 64 hexadecimal digits, the same as the controller's key_file");
  return *key;
}

NetworkRobot::NetworkRobot(const std::string& address, const std::filesystem::path& key_file,
                           std::FILE* ask, std::FILE* answers)
    : address_(address), ask_(ask), answers_(answers), channel_(address), clock_(channel_) {
  link_ = std::make_unique<link::RobotLink>(channel_, clock_, read_key(key_file));
  if (link_->open() != Status::ok)
    throw std::runtime_error(address + ": no controller with this key answers; " +
                             who_answers(link_->identity()));
}

void NetworkRobot::ask_person(const std::string& request) {
  fmt::print(ask_, "\n{} Then press Enter (Ctrl-C ends the session; it can be resumed). ", request);
  std::fflush(ask_);
  for (int c = std::fgetc(answers_); c != '\n'; c = std::fgetc(answers_))
    if (c == EOF)
      throw std::runtime_error(
          "stopped, or nobody answers: a robot on the network needs a person at the terminal; "
          "--resume goes on");
}

/// After a good trial the robot lowers itself; after a fault somebody has to hold it before torque
/// goes off.
void NetworkRobot::bring_to_idle() {
  link_->poll();
  const SupervisorState state = link_->latest().state;
  if (state == SupervisorState::fault) {
    ask_person(fmt::format(
        "The controller is in fault {} (docs/faults.md). Hold the robot: it will be lowered.",
        link_->latest().fault));
    (void)link::lower_and_clear(*link_);
  } else if (state == SupervisorState::hold || state == SupervisorState::soft_stop ||
             state == SupervisorState::stand_up) {
    (void)link_->command({.kind = wire::CommandKind::disarm});
  }
  constexpr double kPatience_s = 30.0;
  const Nanoseconds give_up = clock_.now() + from_seconds(kPatience_s);
  for (link_->poll(); link_->latest().state != SupervisorState::idle;
       link_->wait_observation(clock_.now() + 100 * kMillisecond))
    if (clock_.now() >= give_up)
      throw std::runtime_error(
          fmt::format("{}: not idle after {} s: state {}, fault {} (docs/faults.md)", address_,
                      kPatience_s, static_cast<int>(link_->latest().state), link_->latest().fault));
}

link::RobotLink& NetworkRobot::place(const model::State&, std::uint64_t) {
  bring_to_idle();
  ask_person(
      "Put the robot on its feet on free ground and hold it upright; it will take its first pose "
      "by itself, let go when it stands.");
  return *link_;
}

}  // namespace sanso::app
