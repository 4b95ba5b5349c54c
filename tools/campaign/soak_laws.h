// What holds in every tick, whatever is broken: numbers are finite, targets do not jump, states
// follow the table, a fault stays until it is cleared, who lies on the floor has no torque.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "tools/inprocess/inprocess_robot.h"

namespace sanso::campaign {

class SoakLaws {
 public:
  /// After every tick. `faults_active`: something is being made to go wrong now.
  void look(inprocess::InProcessRobot& robot, bool faults_active);
  /// The next tick is the first of another robot.
  void forget_robot() { fresh_ = true; }
  void broken(const std::string& law) { ++broken_[law]; }

  std::int64_t ticks() const { return ticks_; }
  double largest_step_rad() const { return largest_step_rad_; }
  std::int64_t falls() const { return falls_; }
  const std::map<std::string, std::int64_t>& all_broken() const { return broken_; }
  const std::map<int, std::int64_t>& faults() const { return faults_; }

 private:
  void look_at_state(const firmware::Controller& controller);
  void look_at_targets(const firmware::Controller& controller);
  void look_at_body(const emulator::Truth& truth, bool faults_active);

  bool fresh_ = true;
  std::int64_t ticks_ = 0, falls_ = 0;
  wire::SupervisorState state_{};
  firmware::Fault fault_ = firmware::Fault::none;
  bool torque_ = false, down_ = false;
  model::Input target_ = model::Input::Zero();
  double largest_step_rad_ = 0;
  Nanoseconds down_since_ = -1;
  std::map<std::string, std::int64_t> broken_;
  std::map<int, std::int64_t> faults_;
};

}  // namespace sanso::campaign
