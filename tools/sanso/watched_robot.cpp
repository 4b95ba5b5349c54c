// Buttons belong to the robot that is there: they come with it and are taken away before it goes.
#include "tools/sanso/watched_robot.h"

#include "tools/sanso/truth_sampler.h"

namespace sanso::cli {

using wire::CommandKind;

void add_controller_buttons(page::LivePage& page, page::RobotWatch& watch) {
  page.set_button("estop", [&page, &watch] {
    page.pause(true);  // a session that clears the fault and goes on is not what a person means
    return watch.ask(CommandKind::emergency_stop);
  });
}

void remove_controller_buttons(page::LivePage& page) {
  for (const char* name : {"estop", "lower", "push"}) page.set_button(name, {});
}

WatchedRobot::WatchedRobot(std::unique_ptr<learn::RobotAccess> robot, page::LivePage& page,
                           const std::string& address, const wire::Key& key)
    : robot_(std::move(robot)), page_(page) {
  watch_ = std::make_unique<page::RobotWatch>(
      address, key, [&page](const wire::Observation& o) { page.observe(o); });
  add_controller_buttons(page_, *watch_);
}

WatchedRobot::WatchedRobot(std::unique_ptr<EmulatedAccess> robot, page::LivePage& page)
    : page_(page) {
  const EmulatedAccess& emulated = *robot;
  robot_ = std::move(robot);
  watch_ =
      std::make_unique<page::RobotWatch>(emulated.processes().address(), emulated.processes().key(),
                                         [&page, &emulated](const wire::Observation& o) {
                                           if (const auto truth = emulated.truth().latest())
                                             page.observe(o, truth->foot_load_N);
                                           else
                                             page.observe(o);
                                         });
  add_controller_buttons(page_, *watch_);
  page_.set_button("push", [&emulated] {
    (void)emulated.processes().tell(
        R"({"command": "push", "force": [10, 0, 0], "duration_s": 0.1})");
    return std::string("10 N forward for 0.1 s");
  });
}

WatchedRobot::WatchedRobot(std::unique_ptr<inprocess::InProcessAccess> robot, page::LivePage& page)
    : page_(page) {
  robot->on_new_robot([&page](inprocess::InProcessRobot& made) {
    made.after_tick([&page, &made] {
      const auto& truth = made.trial_truth();
      if (truth.empty()) return page.observe(made.controller().observation());
      const auto& feet = truth.back().truth.foot_force_in_world;
      page.observe(made.controller().observation(), {feet[0][2], feet[1][2]});
    });
  });
  robot_ = std::move(robot);
}

WatchedRobot::~WatchedRobot() {
  remove_controller_buttons(page_);
  watch_.reset();
}

}  // namespace sanso::cli
