// `sanso bench loop`: what the speed of the upper layer buys in closed loop. Whole trials in
// process (firmware, emulated robot, planner) of a squat and of a push while standing, for several
// update periods, horizons and numbers of iterations.
#pragma once

#include <string>
#include <vector>

namespace sanso::cli {

struct LoopCase {
  int period_ticks = 6;  // a plan every so many ticks of 10 ms; the knots stay 60 ms apart
  int horizon = 12;      // states: 12 are 0.72 s, 20 are 1.2 s
  int iterations = 10;   // at most; 10 is to convergence nearly always
};

/// Over the seeds of one task.
struct TaskOutcome {
  double cost = 0;  // mean J of the trials
  double worst_cost = 0;
  int failed = 0;  // trials that ended early: fallen, or J over its limit
};

struct LoopOutcome {
  LoopCase set;
  TaskOutcome squat, push;
  double update_p50_ms = 0, update_p99_ms = 0, update_max_ms = 0;
  int updates = 0, late = 0;
  double wall_per_simulated_s = 0;
};

struct LoopStudyOptions {
  int seeds = 2;
  double push_N = 15.0;  // forward at the trunk's origin, for 0.1 s
  int threads = 2;
  bool only_default = false;  // one case: 60 ms, 0.72 s, to convergence
  bool json = false;
  std::string figure;  // SVG file, empty: none
};

/// Prints a line a case while it runs; exit code 0, or 1 when a policy was late.
int bench_loop(const LoopStudyOptions& options);

}  // namespace sanso::cli
