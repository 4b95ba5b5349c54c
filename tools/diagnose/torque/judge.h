// What the chosen terms are worth on data that nobody fitted, how sure their sizes are, and what
// else would do as well.
#pragma once

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "tools/diagnose/torque/choose.h"

namespace sanso::diagnose {

/// Effort of one joint on the held-out part, RMS in N m (N; the recorded unit where the gain is not
/// determined).
struct EffortScore {
  std::string channel, joint, unit;
  // constant: the mean of the fitted part; zero: no effort at all
  double nominal = 0.0, constant = 0.0, zero = 0.0, patched = 0.0;
  double named = 0.0;  // with the terms alone that predict
  int beyond = 0;      // held-out windows that move faster than anything fitted, and do not judge
  double noise = 0.0;  // what changes from window to window of what is left: nobody's model
  /// The best of those that know no physics.
  double baseline() const { return std::min(constant, zero); }
  bool beats_both() const { return patched < nominal && patched < baseline(); }
};

/// Scale of a drive: what one unit of the recorded effort is in N m.
struct EffortGainFound {
  std::string joint, unit;  // N m for each of `unit`
  double value = 1.0, low = 1.0, high = 1.0;
  bool stated = true;      // the model states it; else found here
  bool determined = true;  // false: efforts are given in the recorded unit
};

/// What is left at one window of one joint, for those who ask whether it is noise.
struct EffortLeft {
  EffortRow row;
  double residual = 0.0;  // N m, patched
  double before = 0.0;    // N m, nominal
};

struct EffortOutcome {
  std::vector<JudgedTerm> terms;
  std::vector<EffortScore> scores;  // by joint that has a known effort
  std::vector<EffortGainFound> gains;
  std::vector<EffortLeft> left;  // all rows, fitted on the fitted part
  std::vector<std::string> heldout_names, notes, log;
  bool heldout_last_part = false;  // of recordings of which the rest was fitted
  std::vector<std::string>
      disagreements;  // of the notes: sizes that do not hold for all recordings
};

/// The whole torque side: terms, choice, judgement.
EffortOutcome explain_effort(const EffortRows& rows, const Settings& settings,
                             const ChooseOptions& options);

}  // namespace sanso::diagnose
