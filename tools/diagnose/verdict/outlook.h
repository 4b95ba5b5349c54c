// How far an answer goes: what the named effects remove of the held-out error, what is left, and
// whether that matters to somebody who predicts this far ahead.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "tools/diagnose/settings.h"
#include "tools/diagnose/verdict/heldout.h"

namespace sanso::diagnose {

/// From best to worst. Names that do no better than a joint that goes on as it went explain a part
/// at most.
enum class Grade {
  explained,  // with the named effects alone, what is left does not matter
  mostly,     // the named effects remove `remains.most` of the error beyond noise
  in_part,    // they remove something
  described,  // the patched model removes that much, and what does it has no certain name
  located,    // none of these: where it shows is known
};
const char* to_string(Grade grade);

struct Outlook {
  Grade grade = Grade::located;
  Horizon horizon;                                // that it is told of
  std::string unit;                               // of the errors
  FitScore score;                                 // of all channels, RMS
  double named_share = 0.0, patched_share = 0.0;  // of the error energy beyond noise, removed
  double matters_from = 0.0;                      // RMS above which what is left matters
  bool matters = false;                           // what the patched model leaves

  /// Error of the patched model in noise levels; 0 where no noise is known.
  double left_in_noise() const { return score.noise > 0.0 ? score.patched / score.noise : 0.0; }
};

/// Of the shortest horizon that was scored and is no shorter than the user's, else of the longest;
/// nothing where none was scored.
std::optional<Outlook> outlook(const HeldoutScores& scores, const std::string& unit,
                               const RemainsSettings& remains, const DecisionSettings& decisions);

/// "mostly explained: the named effects remove 91 % ...": one sentence.
std::string in_words(const Outlook& outlook);

}  // namespace sanso::diagnose
