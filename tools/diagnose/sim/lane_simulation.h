// Runs windows in step, as many as the widest instruction set of this machine has lanes for, and
// follows recordings in step. What a window or a recording becomes does not depend on the others,
// nor on the instruction set.
#pragma once

#include <cstddef>
#include <span>

#include "tools/diagnose/sim/sim_figures.h"

namespace sanso::diagnose {

/// One way to run windows; all of this machine, widest first, one window at a time last.
struct LaneUnit {
  const char* name;
  std::size_t lanes;
  void (*run)(const SimFigures&, const WindowFigures*, std::size_t);
  void (*follow)(const FollowFigures*, std::size_t, const FollowedJoints&);
  void (*replay)(const FollowFigures*, std::size_t, const FollowedJoints&);
  bool (*runs_here)();
};
/// All that were built; `runs_here` asks the machine. Never empty.
std::span<const LaneUnit> lane_units();

/// `unit`: null, the widest of this machine.
void run_windows(const SimFigures& figures, std::span<const WindowFigures> windows,
                 const LaneUnit* unit = nullptr);
/// Writes the inner states at the wanted rows of recordings that one robot made: equal in every
/// figure but time, motion, commands and the servos' gains, and of more than one recording nothing
/// may depend on time but those. `unit`: null, the narrowest of this machine with a lane for each.
void follow_recordings(std::span<const FollowFigures> recordings, const FollowedJoints& joints,
                       const LaneUnit* unit = nullptr);
/// The same for the torques of every row.
void replay_recordings(std::span<const FollowFigures> recordings, const FollowedJoints& joints,
                       const LaneUnit* unit = nullptr);

}  // namespace sanso::diagnose
