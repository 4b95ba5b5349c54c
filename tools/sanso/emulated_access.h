// Controller and robot as two more processes: sanso-emulator behind a pty and sockets,
// sanso-firmware on UDP, real clock.
// What a person does between trials (put the robot on its feet) goes through the emulator's control
// socket.
#pragma once

#include <memory>
#include <string>

#include "host/learn/session/robot_access.h"
#include "host/link/udp_channel.h"
#include "tools/plant/world.h"
#include "tools/sanso/emulated_processes.h"
#include "tools/sanso/truth_sampler.h"

namespace sanso::cli {

class EmulatedAccess : public learn::RobotAccess {
 public:
  /// Starts both programs; their configuration, key and logs go to `folder`. Throws
  /// std::runtime_error.
  EmulatedAccess(const std::string& world, std::uint64_t seed, const std::filesystem::path& folder);
  link::RobotLink& place(const model::State& x, std::uint64_t seed) override;
  void add_measurements(learn::Episode& episode) override;
  std::string description() const override {
    return "emulated (three processes, real clock), world " + world_;
  }
  std::string world_file() const override { return plant::to_toml(plant::load_world(world_)); }
  bool real_time() const override { return true; }
  const EmulatedProcesses& processes() const { return processes_; }
  const TruthSampler& truth() const { return *truth_; }

 private:
  bool reaches_idle(double patience_s);
  void lower_or_clear();
  void bring_to_idle();

  std::string world_;
  EmulatedProcesses processes_;
  link::UdpChannel channel_;
  link::MonotonicClock clock_;
  link::RobotLink link_;
  std::unique_ptr<TruthSampler> truth_;
};

}  // namespace sanso::cli
