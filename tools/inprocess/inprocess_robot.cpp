// Owns clock, robot, controller and link, and runs the controller's tick whenever virtual time
// reaches it.
#include "tools/inprocess/inprocess_robot.h"

#include <algorithm>

#include "shared/grounds/ground_file.h"

namespace sanso::inprocess {

InProcessRobot::InProcessRobot(const plant::World& world, std::uint64_t seed, const wire::Key& key,
                               const firmware::Settings& settings)
    : robot_(world, seed) {
  const firmware::Board board{bus_, imu_, &pose_, network_, clock_};
  firmware_ = std::make_unique<firmware::Firmware>(settings, key, board);
}

bool InProcessRobot::send(const std::uint8_t* data, std::size_t size) {
  if (controller().observation().trial_tick >= host_lost_at_) host_lost_ = true;
  if (!host_lost_) network_.to_controller.emplace_back(data, data + size);
  return true;
}

std::size_t InProcessRobot::receive(std::uint8_t* buffer, std::size_t capacity) {
  if (network_.to_host.empty()) return 0;
  const SimulatedNetwork::Bytes datagram = std::move(network_.to_host.front());
  network_.to_host.pop_front();
  const std::size_t n = std::min(capacity, datagram.size());
  std::copy_n(datagram.begin(), n, buffer);
  return n;
}

void InProcessRobot::wait_until(Nanoseconds time) {
  while (now() < time && network_.to_host.empty()) {
    if (next_tick_ > time) {
      robot_.advance(time);
      return;
    }
    run_tick();
  }
}

void InProcessRobot::finish_computation(Nanoseconds begin, Nanoseconds modelled) {
  const Nanoseconds end = begin + modelled;
  // the robot does not wait for the planner; its observations queue up
  while (next_tick_ <= end) run_tick();
  robot_.advance(end);
}

void InProcessRobot::hold_on_the_way(double strength, const std::string& profile) {
  carriage_.emplace(grounds::load_ground(profile), strength);
}

void InProcessRobot::run_tick() {
  if (carriage_) robot_.support(carriage_->beside(robot_.truth()));
  robot_.advance(next_tick_);
  const Nanoseconds due = next_tick_;
  firmware_->poll_imu(due);
  firmware_->poll_pose(due);
  firmware_->poll_link(due);
  firmware_->tick(due);
  firmware_->poll_link(now());
  record_truth();
  if (controller().observation().trial_tick >= bus_pulled_at_) bus_.pull(true);
  // a tick that ran over starts the next one late, as on a machine
  next_tick_ = std::max(due + kTickPeriod, now());
  if (after_tick_) after_tick_();
}

void InProcessRobot::run_for(double seconds) {
  const Nanoseconds end = now() + from_seconds(seconds);
  while (next_tick_ < end) {
    run_tick();
    network_.to_host.clear();  // nobody listens
  }
}

void InProcessRobot::record_truth() {
  const std::int32_t trial_tick = controller().observation().trial_tick;
  if (trial_tick < 0) return;
  robot_.push_off();  // for whom a hand is at the torso
  if (trial_tick >= push_.trial_tick) {
    robot_.push(push_.force_in_world_N, push_.torque_in_world_Nm, now(),
                now() + from_seconds(push_.duration_s));
    push_ = {};
  }
  trial_truth_.push_back({trial_tick, robot_.truth()});
}

}  // namespace sanso::inprocess
