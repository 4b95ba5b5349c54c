// sanso-emulator and sanso-firmware as two children of this process, joined by a pty and sockets,
// with a fresh key.
#pragma once

#include <memory>
#include <string>

#include "shared/model/state_layout.h"
#include "shared/wire/secure_channel.h"
#include "tools/sanso/child_process.h"

namespace sanso::cli {

class EmulatedProcesses {
 public:
  /// Configuration, key and logs go to `folder`. Throws std::runtime_error with the end of a log
  /// when one does not start.
  EmulatedProcesses(const std::string& world, std::uint64_t seed,
                    const std::filesystem::path& folder);
  ~EmulatedProcesses();

  const wire::Key& key() const { return key_; }
  /// "127.0.0.1:PORT" of the controller.
  std::string address() const;
  const std::string& robot_directory() const { return robot_directory_; }
  /// One command of the emulator's control socket, as a person at the robot would do it; returns
  /// the answer.
  std::string tell(const std::string& json) const;
  /// Puts the robot on its feet in the joint angles of `x` and holds it until it stands by itself.
  void put_on_feet(const model::State& x) const;
  /// Throws std::runtime_error with the end of its log when a child has ended.
  void check();
  std::string firmware_log() const;

  /// Sends a signal to the controller.
  void signal_firmware(int signal) const;
  /// True when the controller has ended, within so long.
  bool firmware_ends(double within_s);
  /// Starts the controller again, on the same address, bus and key. From the thread that made this:
  /// the child ends with it.
  void restart_firmware();

 private:
  void start_emulator(const std::string& world, std::uint64_t seed);
  void start_firmware();

  std::filesystem::path folder_;
  std::string robot_directory_;  // short: a socket's path has to fit 108 bytes
  wire::Key key_;
  int port_ = 0;
  std::unique_ptr<ChildProcess> emulator_, firmware_;
};

}  // namespace sanso::cli
