// A new in-process robot for every trial: so that a trial depends on its seed and on what was
// learned, on nothing else.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "host/app/learn_command.h"
#include "host/learn/session/robot_access.h"
#include "tools/inprocess/inprocess_robot.h"

namespace sanso::inprocess {

/// What a person enters into the controller who puts skates under the robot, and a profile; and
/// what the motion asks for: targets that change faster than the controller's own limit.
firmware::Settings settings_on(bool wheels, const std::string& ground,
                               double target_rate_rad_s = 0.0);

class InProcessAccess : public learn::RobotAccess {
 public:
  /// Throws plant::WorldError when there is no such world.
  explicit InProcessAccess(const std::string& world, const firmware::Settings& settings = {});
  link::RobotLink& place(const model::State& x, std::uint64_t seed) override;
  /// Heat and charge, in a world that tires.
  std::vector<double> condition() const override;
  void set_condition(const std::vector<double>& values) override { condition_ = values; }
  void lend_hand(const learn::Push& push) override { push_ = push; }
  void add_measurements(learn::Episode& episode) override;
  std::string description() const override { return "in-process, world " + world_.name; }
  std::string world_file() const override { return plant::to_toml(world_); }
  bool real_time() const override { return false; }
  InProcessRobot& robot() { return *robot_; }
  /// Called with every new robot before its first tick.
  void on_new_robot(std::function<void(InProcessRobot&)> prepare) { prepare_ = std::move(prepare); }

 private:
  plant::World world_;
  firmware::Settings settings_;
  std::function<void(InProcessRobot&)> prepare_;
  std::optional<learn::Push> push_;  // of a hand that starts the robot
  std::vector<double> condition_;    // of the robot before; empty: a new one
  wire::Key key_{};
  std::unique_ptr<InProcessRobot> robot_;
  std::unique_ptr<link::RobotLink> link_;
};

/// For the session that these options ask for. Throws plant::WorldError when there is no such
/// world.
std::unique_ptr<InProcessAccess> access_for(const app::LearnOptions& options);

}  // namespace sanso::inprocess
