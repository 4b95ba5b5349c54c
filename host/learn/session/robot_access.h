// How a session gets a robot that stands ready for a trial: built anew in process, put up by the
// emulator, or by a person.
#pragma once

#include <string>
#include <vector>

#include "host/learn/episodes/episode.h"
#include "host/link/robot_link.h"

namespace sanso::learn {

class RobotAccess {
 public:
  virtual ~RobotAccess() = default;
  /// A robot on its feet in pose `x`, its controller in idle. `seed` drives whatever is random in
  /// an emulated robot.
  /// Throws std::runtime_error when there is no such robot.
  virtual link::RobotLink& place(const model::State& x, std::uint64_t seed) = 0;
  /// What of the robot outlives a trial (an emulated one's heat and charge), as numbers that only
  /// it reads: the session stores them and gives them back before the next place(). Empty: nothing.
  virtual std::vector<double> condition() const { return {}; }
  virtual void set_condition(const std::vector<double>&) {}
  /// Adds to an episode what only the world knows (foot forces); nothing on a robot that does not
  /// measure them.
  virtual void add_measurements(Episode& episode) = 0;
  /// For reports: "in-process, world lab".
  virtual std::string description() const = 0;
  /// The world as a file that gives it again, for the session's folder; empty for a real robot.
  /// Nothing reads it back.
  virtual std::string world_file() const { return {}; }
  /// Real time: the planner gets a budget and lateness means something.
  virtual bool real_time() const = 0;
};

}  // namespace sanso::learn
