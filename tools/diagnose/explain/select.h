// Forward, backward and swap search over explanations. Every name has to pass: family-wise p,
// held-out gain above chance (moving-block bootstrap over shots), not worse on conditions left out,
// an interval that excludes the null, off its bounds.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/diagnose/explain/rivals.h"
#include "tools/diagnose/fit/fit.h"
#include "tools/diagnose/fit/screen.h"

namespace sanso::diagnose {

struct Accepted {
  std::size_t candidate = 0;
  double p_family = 1.0;
  HeldoutGain gain;           // with it against without it, everything else refitted
  std::vector<double> sigma;  // of its parameters
  std::vector<char> at_bound;
  double low = 0.0, high = 0.0;  // 95 % interval of a random effect's size, from scatter
  // s: when it may have begun, by all of the recorded time; empty: it begins at no instant
  std::optional<std::pair<double, double>> began;
  // the residual that speaks against it; then it describes the data and is no finding
  std::string contradicted;
  std::vector<Alternative> alternatives;  // the others that were fitted in its place, best first
  FitResult without;                      // the final model without it, refitted
};

struct Selection {
  std::optional<Surroundings> around;  // at the final model
  FitResult nominal;                   // nuisances only
  FitResult final;
  Eigen::VectorXd nominal_heldout, final_heldout;  // energy by shot
  std::vector<Accepted> accepted;
  // accepted for what they predict, then dropped: "effect at place (residual)"
  std::vector<std::string> refuted;
  // squares by entry that accepted random effects explain; empty: none
  Eigen::VectorXd expected_scatter;
  Screening first;               // of the nominal model: the family on which detection rests
  std::vector<std::string> log;  // one line a step, for the report
};

class WholeTime;

struct SelectOptions {
  unsigned long seed = 1;
  bool keep_groups = false;  // Selection::first also by held-out group
  // all of the recorded time; nullptr: instants stay where the search's own shots show them
  const WholeTime* whole = nullptr;
  std::function<void(const std::string&)> progress = [](const std::string&) {};
  /// Told what was found whenever it holds together: after the screening, after every step.
  std::function<void(const Selection&)> reached = [](const Selection&) {};
};

/// Selection::around holds the problem as the search left it: scales are the error levels that it
/// found, starts those of the motion that it believes.
Selection select(const Problem& problem, const Library& library, const SelectOptions& options);

}  // namespace sanso::diagnose
