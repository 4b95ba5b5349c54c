// What became of the cases of `sanso bench diagnose`, and the tables that are made of it.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/bench/diagnose/baselines.h"
#include "tools/bench/diagnose/diagnose_bench.h"
#include "tools/bench/diagnose/residual_network.h"
#include "tools/diagnose/verdict/finding.h"

namespace sanso::bench {

struct Outcome {
  unsigned long seed = 0;
  DiagnoseScore score;
  double seconds = 0.0;                    // what a user waits
  std::map<std::string, Names> baselines;  // what simpler methods name
  bool proved = false;                     // the verdict has a held-out score at 0.5 s
  double explained = 0.0;                  // there, of the error beyond noise
  // the same by a search that knows the true effects only; 0: not asked
  double explained_by_truth = 0.0;
  ResidualNetworkScore network;
  // verdict without the true effects in the library
  std::optional<diagnose::VerdictStatus> without_status;
  Names without_named;
};

/// "a + b", or "nothing".
std::string joined(const std::vector<std::string>& names);
/// Prints every table; `left_out`: also what was said without the true effects in the library.
void print_scores(const std::vector<Outcome>& all, bool left_out);

}  // namespace sanso::bench
