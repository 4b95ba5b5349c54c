// Buttons belong to the robot that is there: they come with it and are taken away before it goes.
#include "tools/sanso/watched_robot.h"

#include <atomic>

#include "tools/sanso/truth_sampler.h"

namespace sanso::cli {

using wire::CommandKind;

namespace {

/// What a person has asked of a robot in process, for the thread in which it lives.
struct Asked {
  std::atomic<bool> stop{false}, push{false};
};

constexpr plant::Vec3 kPush_N{10, 0, 0};
constexpr double kPush_s = 0.1;

/// Between two ticks. Without torque there is nothing to stop yet: the stop waits until there is.
void act(Asked& asked, inprocess::InProcessRobot& robot) {
  using wire::SupervisorState;
  const SupervisorState state = robot.controller().observation().state;
  const bool has_torque = state != SupervisorState::boot && state != SupervisorState::self_test &&
                          state != SupervisorState::idle;
  if (has_torque && asked.stop.exchange(false)) robot.handover().emergency_stop = true;
  if (asked.push.exchange(false))
    robot.robot().push(kPush_N, {}, robot.now(), robot.now() + from_seconds(kPush_s));
}

void add_in_process_buttons(page::LivePage& page, const std::shared_ptr<Asked>& asked) {
  page.set_button("estop", [&page, asked] {
    page.emergency_stop_pressed();
    asked->stop = true;
    return std::string("done; the session waits");
  });
  page.set_button("push", [asked] {
    asked->push = true;
    return std::string("10 N forward for 0.1 s");
  });
}

}  // namespace

void add_controller_buttons(page::LivePage& page, page::RobotWatch& watch) {
  page.set_button("estop", [&page, &watch] {
    page.emergency_stop_pressed();
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
  const auto asked = std::make_shared<Asked>();
  add_in_process_buttons(page, asked);
  robot->on_new_robot([&page, asked](inprocess::InProcessRobot& made) {
    asked->stop = asked->push = false;  // that was another robot
    made.after_tick([&page, &made, asked] {
      act(*asked, made);
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
