// `sanso diagnose --predict effort`: the motion is given, the effort is predicted. What is missing
// in the torque at the recorded motion, said as a verdict of the same form.
#pragma once

#include <optional>

#include "tools/diagnose/run/diagnose.h"
#include "tools/diagnose/torque/judge.h"

namespace sanso::diagnose {

struct EffortDiagnosis {
  Verdict verdict;
  EffortOutcome outcome;
  std::optional<ModelFolder> patched;  // what of it the simulator can have
};

/// What a run has found at any moment, for one that is ended early.
struct EffortSoFar {
  std::vector<JudgedTerm> terms;  // chosen; values without intervals
  double removed = 0.0;           // share of the squared error of the fitted part
  std::vector<std::string> notes;
  std::map<std::string, std::string> data_hash;
  unsigned long seed = 0;
  std::string asking = "are the recordings sound?";

  /// Status UNFINISHED.
  EffortDiagnosis diagnosis(double seconds) const;
};

/// The method. Bad input gives a verdict with status REFUSED; throws as `diagnose` does. `so_far`:
/// kept up to date, if given.
EffortDiagnosis diagnose_effort(const DiagnoseOptions& options, const Progress& progress,
                                EffortSoFar* so_far = nullptr);

/// Verdict of an outcome: names, intervals, held-out efforts, what stays unnamed.
Verdict effort_verdict(const EffortOutcome& outcome, const EffortRows& rows,
                       const DiagnoseOptions& options);

struct EffortPatch {
  ModelFolder model;
  std::vector<std::string> notes;  // what it cannot hold
};
/// The model with every term that the library has.
EffortPatch effort_patched(const ModelFolder& model, const EffortOutcome& outcome);

/// A table for people: effort of every joint on held-out data, by model.
std::string effort_table(const EffortOutcome& outcome);
/// The whole text of report.html.
std::string effort_report(const EffortDiagnosis& diagnosis);

/// The command. Exit code 0 no mismatch, 1 mismatch found, 2 refused.
int run_predict_effort(const DiagnoseOptions& options);

}  // namespace sanso::diagnose
