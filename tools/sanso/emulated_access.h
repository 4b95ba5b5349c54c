// Controller and robot as two more processes: sanso-emulator behind a pty and sockets, sanso-firmware on UDP, real clock.
// What a person does between trials (put the robot on its feet) goes through the emulator's control socket.
#pragma once

#include <memory>
#include <string>

#include "host/learn/robot_access.h"
#include "host/link/udp_channel.h"
#include "tools/sanso/child_process.h"
#include "tools/sanso/truth_sampler.h"

namespace sanso::cli {

class EmulatedAccess : public learn::RobotAccess {
 public:
  /// Starts both programs; their configuration, key and logs go to `folder`. Throws std::runtime_error.
  EmulatedAccess(const std::string& world, std::uint64_t seed, const std::filesystem::path& folder);
  ~EmulatedAccess() override;
  link::RobotLink& place(const model::State& x, std::uint64_t seed) override;
  void add_measurements(learn::Episode& episode) override;
  std::string description() const override { return "emulated (three processes, real clock), world " + world_; }
  bool real_time() const override { return true; }

 private:
  void start_emulator(std::uint64_t seed);
  void start_firmware();
  void tell(const std::string& json);
  void wait_for(wire::SupervisorState state, double patience_s, const char* what);
  void check_children();
  void bring_to_idle();

  std::string world_;
  std::filesystem::path folder_;
  std::string robot_directory_;  // short: a socket's path has to fit 108 bytes
  wire::Key key_;
  int port_ = 0;
  std::unique_ptr<ChildProcess> emulator_, firmware_;
  std::unique_ptr<TruthSampler> truth_;
  std::unique_ptr<link::UdpChannel> channel_;
  std::unique_ptr<link::MonotonicClock> clock_;
  std::unique_ptr<link::RobotLink> link_;
};

}  // namespace sanso::cli
