// A real robot (or any running controller) at HOST:PORT: between trials a person puts it on its
// feet.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "host/learn/session/robot_access.h"
#include "host/link/udp_channel.h"

namespace sanso::app {

/// The pre-shared key of a controller. Throws std::runtime_error saying what was expected.
wire::Key read_key(const std::filesystem::path& file);

class NetworkRobot : public learn::RobotAccess {
 public:
  /// `key_file`: the 64 hexadecimal digits that the controller also has. Questions go to `ask`,
  /// answers (Enter) come from `answers`. Throws std::runtime_error when the key cannot be read or
  /// no controller answers.
  NetworkRobot(const std::string& address, const std::filesystem::path& key_file, std::FILE* ask,
               std::FILE* answers);
  link::RobotLink& place(const model::State& x, std::uint64_t seed) override;
  void add_measurements(learn::Episode&) override {}  // nobody outside the controller measures
  std::string description() const override { return "robot at " + address_; }
  bool real_time() const override { return true; }

 private:
  void ask_person(const std::string& request);
  void bring_to_idle();

  std::string address_;
  std::FILE* ask_;
  std::FILE* answers_;
  link::UdpChannel channel_;
  link::MonotonicClock clock_;
  std::unique_ptr<link::RobotLink> link_;
};

}  // namespace sanso::app
