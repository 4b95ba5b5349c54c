// How a session gets a robot that stands ready for a trial: built anew in process, put up by the
// emulator, or by a person.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "host/learn/episodes/episode.h"
#include "host/link/robot_link.h"

namespace sanso::learn {

/// A hand at the torso that keeps a robot on wheels where it is until the trial begins, then brings
/// it evenly to push_m_s within push_s and lets go.
struct Push {
  double push_m_s = 0.0, push_s = 0.0;
  // of a hand that travels along and keeps the torso upright, 0 to 1; 0: there is none
  double hold = 0.0;
};

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
  /// Before place(): the trial begins with this push.
  virtual void lend_hand(const Push&) {
    throw std::runtime_error(description() + ": has no hand that starts a robot on wheels; use " +
                             "--robot in-process");
  }
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
