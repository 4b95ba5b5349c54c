// `sanso bench faults`: runs the scenarios whose names contain the filter, prints a line each, and
// writes the page docs/results/faults.md or JSON.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tools/campaign/witness.h"

namespace sanso::campaign {

struct Options {
  bool json = false;
  std::string filter;      // part of a scenario's name; empty: all
  std::uint64_t seed = 1;  // of the emulated robots
  int threads = 1;         // scenarios at a time
  std::string page;        // file for the page; empty: none
};

struct Row {
  Scenario scenario;
  Found found;
};

/// Exit code: 0 when every row is as expected, 1 when one is not, 2 when no scenario has the filter
/// in its name.
int bench_faults(const Options& options);

/// The page, the JSON, and one line for the terminal.
std::string page_of(const std::vector<Row>& rows, const Options& options);
std::string json_of(const std::vector<Row>& rows, const Options& options);
std::string line_of(const Row& row);

}  // namespace sanso::campaign
