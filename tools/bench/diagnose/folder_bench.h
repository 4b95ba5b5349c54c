// `sanso bench diagnose --folder DIR`: diagnoses every case of a folder that another generator
// made, compares with its answers, and counts family by family, robot by robot.
#pragma once

#include <string>
#include <vector>

#include "tools/bench/diagnose/case_folder.h"
#include "tools/diagnose/settings.h"

namespace sanso::bench {

struct FolderBenchOptions {
  std::string folder;  // of cases, see read_cases
  std::string out;     // one folder a case: verdict.json, outcome.json
  std::vector<double> ratio_bounds{0.0, 1.0, 3.0, 10.0, 30.0};  // rows of the table
  bool resume = false;  // cases whose outcome.json is there are not run again
  bool json = false;
  diagnose::Settings settings;
};

/// One case, judged and timed.
struct CaseOutcome {
  std::string name, robot;
  CaseFamily family = CaseFamily::clean;
  double ratio = 0.0;
  double seconds = 0.0, cpu_seconds = 0.0;  // what a user waits; of all cores together
  std::vector<std::string> truth;
  CaseJudgement said;
  bool proved = false;             // there are held-out recordings
  double explained = 0.0;          // of the squared error at 0.5 s beyond noise, held out
  double explained_bounded = 0.0;  // the same of bounded errors (bounded_error)
  double oracle_explained = 0.0;   // by the true structure, as the answer states it
};

/// Bounded measure of an error of `rms` beside noise `noise`: 50 log(1 + z / 50), z = rms^2 /
/// noise^2. A window that diverged counts a few hundred, not a million.
double bounded_error(double rms, double noise);

/// Share of the error beyond noise that `patched` removes from `nominal`, by window, [-inf, 1];
/// 0 where nothing is beyond noise. Sizes equal.
double explained_share(const std::vector<double>& nominal, const std::vector<double>& patched,
                       double noise, bool bounded);

/// Tables for people: every family by ratio and by robot, confusions, distribution of times.
std::string folder_table(const std::vector<CaseOutcome>& outcomes,
                         const std::vector<double>& ratio_bounds);
std::string folder_json(const std::vector<CaseOutcome>& outcomes);

/// Runs one case after the other (each diagnosis uses all cores, so its time is what a user
/// waits), prints a line each to stderr and the tables at the end. Exit code 0.
int bench_folder(const FolderBenchOptions& options);

}  // namespace sanso::bench
