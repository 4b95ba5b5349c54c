// `sanso learn`: a learning session from the command line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/app/learn_settings.h"
#include "host/learn/session/robot_access.h"
#include "host/learn/session/trial.h"
#include "host/learn/session/watcher.h"
#include "host/motion/motion.h"

namespace sanso::app {

struct LearnOptions {
  std::string motion = "squat";
  int iterations = 10;
  std::string robot = "in-process";  // or "emulated", or HOST:PORT
  std::filesystem::path key;         // of a robot at HOST:PORT: file with the pre-shared key
  std::filesystem::path out;
  bool resume = false;
  std::uint64_t seed = 1;
  std::vector<std::string> without;  // lower, middle, upper, residual, stochastic
  std::string world = "lab";         // of an emulated robot
  // the planner's, and an emulated robot's: "plane", a profile of shared/grounds, a file
  std::string ground = "plane";
  bool wheels = false;  // as the motion says: the robot wears skates
  // as the motion says: guard.max_target_rate_rad_s of the controller; 0: as it is set
  double target_rate_rad_s = 0.0;
  int threads = 2;
  std::string profile = "ours";
  std::vector<std::string> set;  // "mpc.horizon=12"
  std::filesystem::path adopt;   // verdict.json; empty: the planner's own model
  bool quiet = false;
  learn::SessionWatcher* watcher = nullptr;  // may be absent
};

/// Makes the robot that LearnOptions::robot names. Throws std::runtime_error saying what to do.
using RobotFactory = std::function<std::unique_ptr<learn::RobotAccess>(const LearnOptions&)>;

/// The layers that are left without those named. Throws std::runtime_error for an unknown name.
learn::Layers layers_without(const std::vector<std::string>& names);

/// All settings of a session of this motion, as the options leave them. Throws std::runtime_error
/// for a setting or profile that does not exist.
LearnSettings settings_of(const LearnOptions& options, const motion::Motion& motion,
                          bool real_time);

/// Exit code: 0 the last trial succeeded, 1 it failed. Throws std::runtime_error when there is no
/// answer.
int learn(const LearnOptions& options, const RobotFactory& make_robot);

}  // namespace sanso::app
