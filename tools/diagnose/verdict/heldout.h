// The proof on recordings that were not used: the same explanation fitted on one part, scored on
// the other at every horizon.
#pragma once

#include <array>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {

/// One joint, or all of them, at one horizon, on recordings that were not fitted.
struct FitScore {
  double nominal = 0.0, patched = 0.0, noise = 0.0;
  // what any model has to beat: the joint goes on at the speed that it had at the start (of an
  // effort: its mean); NaN: not asked
  double baseline = std::numeric_limits<double>::quiet_NaN();
  // with the effects alone that have a name; NaN: not asked
  double named = std::numeric_limits<double>::quiet_NaN();
  // (nominal^2 - patched^2) / (nominal^2 - noise^2), energies; 0 when nothing to explain
  double explained() const;
  /// The same of another model's error.
  double explained_by(double error) const;
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
  bool last_part = false;  // of the only recording: no whole one judges
};
/// Needs at least one source.
Split make_split(const std::vector<Source>& sources);

/// The problem's shots inside a part; at least one shot or the problem unchanged.
Problem restricted(const Problem& problem, const Part& part);

/// How far ahead of a measured state is predicted.
class Horizon {
 public:
  /// Nothing runs ahead: efforts, forces and readings, told along the recorded motion.
  static Horizon recorded_motion() { return {}; }
  /// Positions, so many seconds ahead; kept to the three digits that files give.
  static Horizon ahead(double seconds);

  bool runs_ahead() const { return seconds_ > 0.0; }
  /// 0 along the recorded motion.
  double seconds() const { return seconds_; }
  /// "0.5", in s; "0" along the recorded motion.
  std::string text() const;
  bool operator==(const Horizon&) const = default;
  /// By text, "10" before "2": the order in which files give them.
  bool operator<(const Horizon& other) const { return text() < other.text(); }

 private:
  double seconds_ = 0.0;
};

/// At which models are asked, beside the user's own horizon.
inline constexpr std::array kHorizons_s{0.1, 0.5, 2.0};

/// RMSE at one horizon. Of positions: restarted from the measured state, in rad (m).
struct HorizonScores {
  std::optional<FitScore> all;  // the channels together; nothing: they have no common unit
  std::map<std::string, FitScore> channels;
};
using HeldoutScores = std::map<Horizon, HorizonScores>;

/// Models that are scored: the explanation, and what of it has a name. Compared with them are the
/// plain model folder and a joint that goes on as it went.
struct Explained {
  Model patched, named;
};
/// At `kHorizons_s`, and at the user's own horizon (settings.remains.horizon).
HeldoutScores heldout_scores(const std::vector<Source>& sources,
                             const std::vector<NoiseLevel>& noise, const Library& library,
                             const Explained& models, const Part& heldout,
                             const Settings& settings);

/// The structure that was found, its parameters fitted without the held-out part, and how it did
/// there.
struct HeldoutProof {
  HeldoutScores scores;
  std::vector<std::string> recordings;  // held out
  bool last_part = false;               // of the only recording
  Part part;                            // held out
  Model model;                          // fitted to the rest
};
/// `sources`: the recordings with the motion as it was before the search; `around`, `final`: where
/// the search ended. `named`: by effect of `final`, not 0 where it has a name.
HeldoutProof prove(const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
                   const Surroundings& around, const Model& final, const std::vector<char>& named);

}  // namespace sanso::diagnose
