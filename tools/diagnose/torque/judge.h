// What the chosen terms are worth on data that nobody fitted, how sure their sizes are, and what
// else would do as well.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/diagnose/torque/choose.h"

namespace sanso::diagnose {

struct JudgedValue {
  double value = 0.0, low = 0.0, high = 0.0;  // 95 %, block bootstrap over all data
  std::string unit;
  bool at_bound = false;
};

struct JudgedTerm {
  EffortTerm term;
  std::vector<JudgedValue> values;  // by column
  // share of the nominal model's held-out error at its joints that goes with this term alone
  double heldout_gain = 0.0, heldout_gain_low = 0.0;
  bool predicts = false;                  // the bound that chance leaves is above zero
  bool spans_null = true;                 // every interval holds zero
  std::vector<std::string> equally_good;  // simpler or as simple names that predict as well
};

/// Effort of one joint on the held-out part, RMS in N m (N; the recorded unit where the gain is not
/// determined).
struct EffortScore {
  std::string channel, joint, unit;
  double nominal = 0.0, constant = 0.0, patched = 0.0;  // constant: the mean of the fitted part
  double noise = 0.0;  // what changes from window to window of what is left: nobody's model
  bool beats_both() const { return patched < nominal && patched < constant; }
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
};

/// The whole torque side: terms, choice, judgement.
EffortOutcome explain_effort(const EffortRows& rows, const Settings& settings,
                             const ChooseOptions& options);

}  // namespace sanso::diagnose
