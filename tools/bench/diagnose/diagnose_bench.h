// `sanso bench diagnose`: conceals cases, diagnoses them, has the answers revealed, counts. Cases
// are made and opened by the caller's functions: neither this folder nor the diagnosis can read an
// answer.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/bench/diagnose/case_family.h"
#include "tools/diagnose/settings.h"

namespace sanso::bench {

struct DiagnoseCase {
  std::string model;                    // folder
  std::vector<std::string> recordings;  // files
};

/// What the revealed answer says about a verdict.
struct DiagnoseScore {
  CaseFamily family = CaseFamily::clean;
  // severity reached by the faintest effect, of 0.3, 1, 3, 10, 30 the nearest; 0: none
  double ratio = 0.0;
  std::vector<std::string> truth, named;
  int confirmed = 0, wrong_confirmed = 0;  // findings; of them not in the world
  std::string status;
  bool detected = false, named_first = false, in_set = false, where_exact = false,
       refused_by_name = false, unnamed = false, right = false;
  double set_size = 0.0, f1 = 0.0;
  std::map<std::string, double> relative_error;
  std::map<std::string, bool> covered;
};

struct DiagnoseBenchOptions {
  int cases = 20;
  unsigned long seed = 1;
  std::string robot = "pendulum";
  std::string folder;      // where the cases are put
  double minutes = 0.0;    // no case is begun later than this; 0: all are run
  bool leave_out = false;  // each case again with its true effects taken out of the library
  bool json = false;
  diagnose::Settings settings;
  std::function<DiagnoseCase(unsigned long seed, const std::string& robot,
                             const std::string& folder)>
      conceal;
  std::function<DiagnoseScore(const std::string& folder, const std::string& verdict_file)> reveal;
};

/// Prints every score with its 95 % interval by family and ratio, the confusion list, failures with
/// their seeds, times.
/// Exit code 0.
int bench_diagnose(const DiagnoseBenchOptions& options);

}  // namespace sanso::bench
