// `sanso bench mpc`: the time of one policy update, along a walk, beside the same iLQG on MuJoCo.
#pragma once

#include <cstdint>
#include <string>

#include "host/mpc/mpc_settings.h"

namespace sanso::bench {

struct BenchMpcOptions {
  int updates = 2000;
  bool peer = false;  // also run the MuJoCo peer, interleaved
  int peer_updates = 200;
  // with the network (random weights of plausible size: the time does not depend on them)
  bool residual = true;
  double disturbance = 0.5;  // 1: centimetres and hundredths of a radian
  bool json = false;
  std::string motion = "walk_forward";
  std::string lanes;     // "avx512", "avx2", "portable"; empty: the widest this processor has
  double budget_ms = 0;  // time given to the solver, 0: none
  mpc::MpcSettings mpc;
};

struct TimeSummary {
  double p50 = 0, p99 = 0, max = 0;  // ms
};

struct BenchMpcResult {
  TimeSummary update_ms;       // all updates
  TimeSummary undisturbed_ms;  // updates during which the scheduler took no processor away
  int updates = 0, undisturbed = 0;
  double iterations = 0;  // mean
  double max_iterations = 0;
  int cut_short = 0;  // updates that the time budget ended
  int threads = 0;
  double dynamics_eval_us = 0;  // one evaluation, one lane of eight
  double predict_ms = 0, linearize_ms = 0, backward_ms = 0, line_search_ms = 0;  // mean per update
  double cost_before = 0, cost_after = 0;                                        // medians
  std::string lanes;                                                             // instruction set
  // the peer
  int peer_updates = 0;
  TimeSummary peer_ms;
  double peer_iterations = 0, peer_cost_after = 0;
  double peer_step_us = 0, peer_linearize_ms = 0;
  double ratio = 0;  // median of peer / ours, update by update, both to convergence
  // the same with ours stopped at the iteration that reaches the peer's cost
  double same_cost_ratio = 0;
  // updates in which the peer's cost, in its own model, was lower than ours in our model
  int peer_cheaper = 0;
};

BenchMpcResult run_bench_mpc(const BenchMpcOptions& options);
/// Runs, prints a table or JSON. Exit code.
int bench_mpc(const BenchMpcOptions& options);

}  // namespace sanso::bench
