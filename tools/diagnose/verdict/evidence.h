// What was measured, from which a verdict is concluded: plain values, no fits and no recordings.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/diagnose/gate/gate.h"
#include "tools/diagnose/verdict/experiment.h"
#include "tools/diagnose/verdict/finding.h"
#include "tools/diagnose/verdict/heldout.h"
#include "tools/diagnose/verdict/limits.h"
#include "tools/diagnose/verdict/location_map.h"
#include "tools/diagnose/verdict/remains.h"

namespace sanso::diagnose {

/// What the search tells beside the names that it found.
struct SearchRecord {
  // some candidate stood out in the first screening: the error is no noise, whether or not a name
  // passed the later gates
  bool detected = false;
  // stay in the model though a residual speaks against them: "effect at place (residual)"
  std::vector<std::string> described;
  // all that was found, one figure whose interval contains the null: it may be nothing, and is no
  // mismatch
  std::vector<std::string> doubtful;
  // predictions gained from them, and a residual spoke against them: likewise
  std::vector<std::string> refuted;
  std::string nearest_effect;  // strongest of the first screening; empty: nothing was screened
};
/// In words of the library.
SearchRecord record_of(const Library& library, const Selection& selection);

/// What a run that was ended early tells of its end.
struct Unfinished {
  std::string asking;    // the question at which it was ended
  double seconds = 0.0;  // since its start
  double removed = 0.0;  // share of the nominal error on left-out groups, by what was accepted
};

struct Evidence {
  // not empty: the data were refused, and nothing below was measured
  std::vector<Defect> defects;
  std::vector<std::string> joints;
  LocationMap before, after;  // errors of the nominal and of the last model
  std::vector<Finding> findings;
  SearchRecord search;
  Remains left;
  HeldoutProof proof;
  std::vector<Untestable> untestable;
  std::vector<Detectable> detectable;
  std::optional<NextExperiment> next_experiment;
  std::vector<std::string> notes;                // of the gate
  std::vector<std::string> disagreements;        // sizes that do not hold for all recordings
  std::map<std::string, std::string> data_hash;  // file -> hash
  DecisionSettings decisions;                    // by which what is left counts
  RemainsSettings remains;
  std::string unit = "rad";              // of the positions
  std::optional<Unfinished> unfinished;  // nothing below the search was measured
  unsigned long seed = 0;
};

}  // namespace sanso::diagnose
