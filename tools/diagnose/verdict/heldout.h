// The proof on recordings that were not used: the same explanation fitted on one part, scored on
// the other at every horizon.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/diagnose/fit/fit.h"
#include "tools/diagnose/verdict/verdict.h"

namespace sanso::diagnose {

/// A part of the recordings: by source, the time span [from, until) as shares of its length.
struct Part {
  std::vector<double> from, until;
};

/// What is fitted and what is held out. Several conditions: the smallest condition is held out;
/// several recordings: about a third of them (every third); one recording: its last third.
struct Split {
  Part fitted, heldout;
  std::vector<std::string> heldout_names;
};
Split make_split(const std::vector<Source>& sources);

/// The problem's shots inside a part; at least one shot or the problem unchanged.
Problem restricted(const Problem& problem, const Part& part);

/// RMSE of the positions restarted from the measured state at every horizon, in rad (m); by channel
/// and "all".
/// `nominal` is the plain model folder, `patched` the explanation. horizon text -> channel ->
/// score.
std::map<std::string, std::map<std::string, FitScore>> heldout_scores(
    const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
    const Library& library, const Model& patched, const Part& heldout, const Settings& settings);

}  // namespace sanso::diagnose
