// The proof on recordings that were not used: the same explanation fitted on one part, scored on
// the other at every horizon.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {

/// One joint (or "all") at one horizon, on recordings that were not fitted.
struct FitScore {
  double nominal = 0.0, patched = 0.0, noise = 0.0;
  // (nominal^2 - patched^2) / (nominal^2 - noise^2), energies; 0 when nothing to explain
  double explained() const;
};

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

/// RMSE of the positions restarted from the measured state at every horizon, in rad (m):
/// horizon text -> channel or "all" -> score.
using HeldoutScores = std::map<std::string, std::map<std::string, FitScore>>;

/// `nominal` is the plain model folder, `patched` the explanation.
HeldoutScores heldout_scores(const std::vector<Source>& sources,
                             const std::vector<NoiseLevel>& noise, const Library& library,
                             const Model& patched, const Part& heldout, const Settings& settings);

/// The structure that was found, its parameters fitted without the held-out part, and how it did
/// there.
struct HeldoutProof {
  HeldoutScores scores;
  std::vector<std::string> recordings;  // held out
  Part part;                            // held out
  Model model;                          // fitted to the rest
};
/// `sources`: the recordings with the motion as it was before the search; `around`, `final`: where
/// the search ended.
HeldoutProof prove(const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
                   const Surroundings& around, const Model& final);

}  // namespace sanso::diagnose
