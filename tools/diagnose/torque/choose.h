// Which terms the missing effort is made of: chosen one by one on the fitted part by left-out
// blocks, and again with the weights that what is left suggests.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/diagnose/torque/effort_fit.h"

namespace sanso::diagnose {

struct ChooseOptions {
  std::vector<std::string> effects;  // only these; empty: all
  std::vector<std::string> without;  // but these
  unsigned long seed = 1;
  std::function<void(const std::string&)> progress = {};
};

/// Blocks that are fitted and blocks that judge (0 or 1).
struct EffortSplit {
  BlockCounts fitted, heldout;
  std::vector<std::string> heldout_names;
};
/// Several conditions: the smallest is held out; three recordings and more: every third; else the
/// last part of every recording.
EffortSplit split_blocks(const EffortRows& rows, const EffortSettings& settings);

struct EffortChoice {
  std::vector<int> nuisances, terms;  // indices of the design's terms
  std::vector<std::string> log;
  std::vector<int> active() const;                  // both
  std::vector<int> active_without(int term) const;  // both but one
};

/// Gain of `with` over `without`, block by block, where each is fitted to the other folds of the
/// fitted part; blocks that are not fitted are left out. `joints`: of their rows alone.
struct EffortGain {
  double gain = 0.0, low = 0.0;  // weighted squared error, and the bound that chance leaves
  double share = 0.0;            // of what `without` leaves at these joints
};
EffortGain crossed_gain(const EffortDesign& design, const std::vector<int>& without,
                        const std::vector<int>& with, const BlockCounts& fitted,
                        const std::vector<int>& joints, const Settings& settings,
                        unsigned long seed);

/// Appends the ripples it looks at to the design, and leaves it with the weights of the end.
EffortChoice choose_terms(EffortDesign& design, const EffortSplit& split, const Settings& settings,
                          const ChooseOptions& options);

/// In words: "coulomb_friction at knee", "cogging at motor (order 7)".
std::string in_words(const EffortTerm& term);

}  // namespace sanso::diagnose
