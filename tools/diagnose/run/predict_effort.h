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

/// The method. Bad input gives a verdict with status REFUSED; throws as `diagnose` does.
EffortDiagnosis diagnose_effort(const DiagnoseOptions& options, const Progress& progress);

/// Verdict of an outcome: names, intervals, held-out efforts (horizon "0"), what stays unnamed.
Verdict effort_verdict(const EffortOutcome& outcome, const EffortRows& rows,
                       const DiagnoseOptions& options);

/// The model with every term that the library has; `notes` says what it cannot hold.
ModelFolder effort_patched(const ModelFolder& model, const EffortOutcome& outcome,
                           std::vector<std::string>& notes);

/// A table for people: effort of every joint on held-out data, by model.
std::string effort_table(const EffortOutcome& outcome);
std::string effort_report(const EffortDiagnosis& diagnosis);

/// The command. Exit code 0 no mismatch, 1 mismatch found, 2 refused.
int run_predict_effort(const DiagnoseOptions& options);

}  // namespace sanso::diagnose
