// Runs windows in step, as many as the widest instruction set of this machine has lanes for. What a
// window becomes does not depend on the others, nor on the instruction set.
#pragma once

#include <cstddef>
#include <span>

#include "tools/diagnose/sim/sim_figures.h"

namespace sanso::diagnose {

/// One way to run windows; all of this machine, widest first, one window at a time last.
struct LaneUnit {
  const char* name;
  void (*run)(const SimFigures&, const WindowFigures*, std::size_t);
  bool (*runs_here)();
};
/// All that were built; `runs_here` asks the machine. Never empty.
std::span<const LaneUnit> lane_units();

/// `unit`: null, the widest of this machine.
void run_windows(const SimFigures& figures, std::span<const WindowFigures> windows,
                 const LaneUnit* unit = nullptr);

}  // namespace sanso::diagnose
