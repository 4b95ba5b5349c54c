// `sanso bench page`: what the live page costs the robot. Sessions of three processes on the real
// clock, one without the page and one with the page open in a browser, in turn.
#pragma once

#include <filesystem>
#include <string>

namespace sanso::cli {

struct PageCostOptions {
  std::string motion = "squat";
  int rounds = 3;  // of one session without and one with the page
  int trials = 2;  // of each session
  std::filesystem::path browser;
  std::filesystem::path out = "out/bench_page";
  bool json = false;
};

/// Prints a line a case; exit code 0, or 1 when a policy was late only while the page was open.
int bench_page(const PageCostOptions& options);

}  // namespace sanso::cli
