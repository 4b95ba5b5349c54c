// What servos and transmissions remember where windows begin: recordings are followed from their
// beginning up to there, or from a while before.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tools/diagnose/sim/simulator.h"

namespace sanso::diagnose {

/// One recording, the robot as it is supposed, and the windows.
struct Followed {
  const SimParams* params = nullptr;
  const Drive* drive = nullptr;
  const MeasuredMotion* motion = nullptr;
  std::span<const Window> windows;  // in order of `first`
  std::uint64_t random_seed = 0;    // SimOptions::random_seed
  double recalled_s = kNone;        // s before a window from which it is followed
};

/// Inner states by window, for each recording; none where nothing is remembered. Recordings of
/// robots that are equal but for their servos' gains are followed in step (lane_simulation.h),
/// which changes no bit.
/// `options`: its step, its choice of joints, its unit.
std::vector<std::vector<InnerStates>> follow(std::span<const Followed> recordings,
                                             const SimOptions& options);

/// Which of the recordings follow() takes in step: indices, by group; those without motion or
/// windows are in none.
std::vector<std::vector<std::size_t>> in_step(std::span<const Followed> recordings);

}  // namespace sanso::diagnose
