// `sanso diagnose` of a robot whose base floats: from a model folder and recordings to a verdict of
// the same form as that of a fixed base.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/diagnose/wholebody/questions.h"

namespace sanso::diagnose {

struct WholeOptions {
  std::string model;                    // model folder
  std::vector<std::string> recordings;  // files
  std::vector<std::string> effects;     // of drives and links, that may be named; empty: all
  Settings settings;
  unsigned long seed = 1;
};

struct WholeDiagnosis {
  Verdict verdict;
  std::string proof;  // the verdict's summary is its plain_words() and this
  std::optional<WholeBody> nominal, patched;
  std::vector<std::string> log;
  std::vector<WholeRecording> recordings;   // what was asked; of the method that reads files
  std::optional<StanceShown> stance;        // where drives and links were asked
  std::shared_ptr<const NamesApart> apart;  // what is left undecided of them
};

/// Whether this model's base floats; a folder that cannot be read has none.
bool floats(const std::string& model_folder);

/// The whole method. Bad input gives a verdict with status REFUSED, and so do recordings that
/// answer none of the questions.
WholeDiagnosis diagnose_whole(const WholeOptions& options,
                              const std::function<void(const std::string&)>& progress);

/// The same of what is in memory, judged already.
WholeDiagnosis diagnose_whole(const WholeOptions& options, const WholeBody& body,
                              const WholeData& data,
                              const std::function<void(const std::string&)>& progress);

}  // namespace sanso::diagnose
