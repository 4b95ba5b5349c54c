// What a diagnosis says: the content of verdict.json, and nothing else. Field names are the file's
// keys (stable).
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
#include "tools/diagnose/verdict/outlook.h"
#include "tools/diagnose/verdict/remains.h"
#include "tools/diagnose/verdict/unexplained.h"

namespace sanso::diagnose {

struct Verdict {
  bool mismatch = false;
  VerdictStatus status = VerdictStatus::absent;
  std::string answer;   // one sentence, in the library's ids
  std::string summary;  // one paragraph for people (plain_words.h)
  std::optional<Unfinished> unfinished;
  std::optional<Outlook> outlook;  // how far the names go, and whether what is left matters
  std::vector<Finding> findings;
  std::vector<LocationCell> locations;
  HeldoutScores heldout;
  std::vector<std::string> heldout_recordings;
  bool heldout_last_part = false;  // of recordings of which the rest was fitted
  std::vector<Defect> refused;
  std::vector<Untestable> untestable;
  std::vector<Detectable> detectable;
  std::optional<NextExperiment> next_experiment;
  std::optional<Unexplained> unexplained;
  std::vector<Stretch> stretches;  // strongest first
  std::vector<std::string> notes;
  std::vector<std::string>
      disagreements;  // of the notes: sizes that do not hold for all recordings
  std::map<std::string, std::string> data_hash;  // file -> hash
  unsigned long seed = 0;
};

/// The text of verdict.json.
std::string verdict_json(const Verdict& verdict);

}  // namespace sanso::diagnose
