// Firmware, emulated robot and the host's link in one process on one virtual clock: the real bytes
// of bus, IMU and wire, deterministic given the seed, as fast as the machine. The host waiting is
// what makes the robot live.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/app/firmware.h"
#include "host/link/channel.h"
#include "tools/inprocess/carriage.h"
#include "tools/inprocess/simulated_board.h"

namespace sanso::inprocess {

class InProcessRobot : public link::DatagramChannel, public link::HostClock {
 public:
  InProcessRobot(const plant::World& world, std::uint64_t seed, const wire::Key& key,
                 const firmware::Settings& settings = {});

  // link::DatagramChannel
  bool send(const std::uint8_t* data, std::size_t size) override;
  std::size_t receive(std::uint8_t* buffer, std::size_t capacity) override;

  // link::HostClock: virtual time of the world
  Nanoseconds now() override { return robot_.now(); }
  void wait_until(Nanoseconds time) override;
  void finish_computation(Nanoseconds begin, Nanoseconds modelled) override;

  /// One tick of the controller, with everything that its other threads would do around it.
  void run_tick();
  void run_for(double seconds);

  /// The host is gone from this tick of the trial on, as if killed: its datagrams do not leave any
  /// more.
  void lose_host_at(std::int32_t trial_tick) { host_lost_at_ = trial_tick; }
  /// The bus cable is pulled out at this tick of the trial.
  void pull_bus_at(std::int32_t trial_tick) { bus_pulled_at_ = trial_tick; }

  /// Somebody pushes the torso from this tick of the next trial on.
  struct Push {
    std::int32_t trial_tick = INT32_MAX;
    double duration_s = 0.0;
    plant::Vec3 force_in_world_N{};
    plant::Vec3 torque_in_world_Nm{};  // about the torso's origin
  };
  void push_at(const Push& push) { push_ = push; }

  /// A hand travels along at the torso from when nobody else holds it, with this strength, upright
  /// on the profile.
  void hold_on_the_way(double strength, const std::string& profile);

  /// Called after every tick of the controller, with the world as it is then.
  void after_tick(std::function<void()> look) { after_tick_ = std::move(look); }

  emulator::EmulatedRobot& robot() { return robot_; }
  /// What the controller's other threads hand over; a person's emergency stop among it.
  firmware::Handover& handover() { return firmware_->handover(); }
  const firmware::Controller& controller() const { return firmware_->controller(); }
  SimulatedSerialPort& bus() { return bus_; }

  struct TrialTruth {
    std::int32_t trial_tick = 0;
    emulator::Truth truth;
  };
  /// What really was at every tick of the trials so far, for costs and reports.
  const std::vector<TrialTruth>& trial_truth() const { return trial_truth_; }
  void forget_trials() { trial_truth_.clear(); }

 private:
  void record_truth();

  emulator::EmulatedRobot robot_;
  SimulatedClock clock_{robot_};
  SimulatedSerialPort bus_{robot_};
  SimulatedImu imu_{robot_};
  SimulatedPose pose_{robot_};
  SimulatedNetwork network_;
  std::unique_ptr<firmware::Firmware> firmware_;  // large: tables of the layers
  Nanoseconds next_tick_ = 0;
  std::int32_t host_lost_at_ = INT32_MAX, bus_pulled_at_ = INT32_MAX;
  bool host_lost_ = false;
  Push push_;
  std::optional<Carriage> carriage_;
  std::vector<TrialTruth> trial_truth_;
  std::function<void()> after_tick_;
};

}  // namespace sanso::inprocess
