// `sanso diagnose`: from a model folder and recordings to a verdict, a patched model and everything
// the report shows.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/diagnose/model_folder/model_folder.h"
#include "tools/diagnose/run/first_look.h"
#include "tools/diagnose/run/shown.h"
#include "tools/diagnose/verdict/verdict.h"

namespace sanso::diagnose {

struct DiagnoseOptions {
  std::string model;                    // model folder
  std::vector<std::string> recordings;  // files
  // folder for verdict.json, report.html, model/; empty: nothing is written
  std::string out;
  std::vector<std::string> effects;  // restrict the library to these ids; empty: all
  std::vector<std::string> without;  // leave these ids out of the library (leave-one-out proofs)
  bool json = false;                 // print verdict.json instead of the summary
  bool quiet = false;                // no progress lines
  unsigned long seed = 1;
  bool free_gain = false;   // --predict effort: no drive's scale is taken as known
  double time_limit = 0.0;  // s, after which a run ends as by Ctrl-C; 0: none
  Settings settings;
  // fills FirstLook::by_group, for methods that are compared with this one
  bool first_look_by_group = false;
};

/// All that was found out; the verdict is what counts, the rest feeds the report.
struct Diagnosis {
  Verdict verdict;
  std::optional<ModelFolder> patched;
  LocationMap before, after;
  std::vector<std::string> regimes, joints;
  std::vector<char> slides;                                          // by joint, not 0: prismatic
  std::vector<std::vector<ShapeCurve>> curves_before, curves_after;  // by joint of `shown_joints`
  std::vector<std::size_t> shown_joints;
  std::vector<RollOut> roll_outs;
  std::vector<ShownMotion> motions;
  std::vector<std::string> log;
  FirstLook first_look;
};

using Progress = std::function<void(const std::string&)>;

/// What a run has found at any moment, for one that is ended early.
struct SoFar {
  Evidence evidence;
  std::optional<ModelFolder> patched;
  std::vector<std::string> log;
  std::string asking = "are the recordings sound?";

  /// Status UNFINISHED. Simulates nothing.
  Diagnosis diagnosis(double seconds) const;
};

/// The whole method. Bad input gives a verdict with status REFUSED; nothing is thrown but
/// Interrupted, and std::invalid_argument for settings outside their range. `so_far`: kept up to
/// date, if given.
Diagnosis diagnose(const DiagnoseOptions& options, const Progress& progress,
                   SoFar* so_far = nullptr);

/// The command: runs, prints, writes `out`. Exit code 0 no mismatch, 1 mismatch found, 2 refused.
int run_diagnose(const DiagnoseOptions& options);
/// The same for a model whose base floats (wholebody/).
int run_diagnose_whole(const DiagnoseOptions& options);

}  // namespace sanso::diagnose
