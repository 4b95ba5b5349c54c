// Which terms the missing effort is made of: chosen one by one on the fitted part by left-out
// blocks, and again with the weights that what is left suggests.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/diagnose/torque/effort_gain.h"

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

struct ChooseOptions {
  std::vector<std::string> effects;  // only these; empty: all
  std::vector<std::string> without;  // but these
  unsigned long seed = 1;
  std::function<void(const std::string&)> progress = {};
  /// Told what is chosen after every choice: values without intervals, and the share of the
  /// fitted part's squared error that they remove.
  std::function<void(const std::vector<JudgedTerm>&, double removed)> reached = {};
};

/// Blocks that are fitted and blocks that judge (0 or 1).
struct EffortSplit {
  BlockCounts fitted, heldout;
  std::vector<std::string> heldout_names;
  bool last_part = false;  // of recordings of which the rest is fitted
};
/// Several conditions: the smallest is held out; three recordings and more: every third; else the
/// last part of every recording.
EffortSplit split_blocks(const EffortRows& rows, const EffortSettings& settings);

struct EffortChoice {
  std::vector<std::size_t> nuisances, terms;  // indices of the design's terms
  std::vector<std::string> log;
  std::vector<std::size_t> active() const;                          // both
  std::vector<std::size_t> active_without(std::size_t term) const;  // both but one
  /// The nuisances, and the terms whose place in `terms` is kept.
  std::vector<std::size_t> active_with(const std::function<bool(std::size_t)>& kept) const;
};

/// Appends the ripples it looks at to the design, and leaves it with the weights of the end.
EffortChoice choose_terms(EffortDesign& design, const EffortSplit& split, const Settings& settings,
                          const ChooseOptions& options);

/// In words: "coulomb_friction at knee", "cogging at motor (order 7)".
std::string in_words(const EffortTerm& term);

}  // namespace sanso::diagnose
