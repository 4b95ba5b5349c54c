// What to record next: the setting or motion under which the candidates of a set would differ most
// (T-optimal design: the rival may refit its own parameters and the nuisances before the difference
// counts).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/diagnose/explain/select.h"
#include "tools/diagnose/verdict/finding.h"

namespace sanso::diagnose {

/// What an experiment changes: a setting of the robot or its bench, or the motion commanded.
enum class ExperimentKind { setting, motion };
const char* to_string(ExperimentKind kind);

struct NextExperiment {
  std::string what;  // in words
  ExperimentKind kind = ExperimentKind::setting;
  std::vector<std::string> separates;
  // NaN where nobody has simulated it
  double nats_per_second = 0.0;
  double seconds_to_100_to_1 = 0.0;
  std::string motion_file;  // that a robot can run, beside the verdict; empty: none was made
};

/// Tries every entry of the menu by simulation: the recorded motions again with half and double
/// gain, a payload, a tilted base, a higher supply; then the same with commands half as large, half
/// as fast, twice as fast. `sets`: for every finding the fitted alternatives that cannot be told
/// apart from it. Nothing when no finding has one, or no entry separates them.
std::optional<NextExperiment> next_experiment(const Problem& problem, const Library& library,
                                              const Selection& selection,
                                              const std::vector<Finding>& findings);

}  // namespace sanso::diagnose
