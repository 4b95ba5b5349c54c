// A robot of a session with the page beside it. What the page sees comes from a second session with
// the same controller, or in process from the controller itself.
#pragma once

#include <memory>

#include "tools/inprocess/inprocess_access.h"
#include "tools/page/live_page.h"
#include "tools/page/robot_watch.h"
#include "tools/sanso/emulated_access.h"

namespace sanso::cli {

/// Forwards everything; its page forgets the robot before the robot goes.
class WatchedRobot : public learn::RobotAccess {
 public:
  /// On the network: address and key of its controller.
  WatchedRobot(std::unique_ptr<learn::RobotAccess> robot, page::LivePage& page,
               const std::string& address, const wire::Key& key);
  /// Three processes: the emulator knows the load of the feet and can be pushed.
  WatchedRobot(std::unique_ptr<EmulatedAccess> robot, page::LivePage& page);
  /// In process, in virtual time: it can be stopped and pushed too.
  WatchedRobot(std::unique_ptr<inprocess::InProcessAccess> robot, page::LivePage& page);
  ~WatchedRobot() override;

  link::RobotLink& place(const model::State& x, std::uint64_t seed) override {
    return robot_->place(x, seed);
  }
  std::vector<double> condition() const override { return robot_->condition(); }
  void set_condition(const std::vector<double>& values) override { robot_->set_condition(values); }
  void lend_hand(const learn::Push& push) override { robot_->lend_hand(push); }
  void add_measurements(learn::Episode& episode) override { robot_->add_measurements(episode); }
  std::string description() const override { return robot_->description(); }
  std::string world_file() const override { return robot_->world_file(); }
  bool real_time() const override { return robot_->real_time(); }

 private:
  std::unique_ptr<learn::RobotAccess> robot_;
  page::LivePage& page_;
  std::unique_ptr<page::RobotWatch> watch_;
};

/// The buttons of a controller: emergency stop (which also holds the session), and lower.
void add_controller_buttons(page::LivePage& page, page::RobotWatch& watch);
void remove_controller_buttons(page::LivePage& page);

}  // namespace sanso::cli
