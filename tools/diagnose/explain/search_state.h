// Where a search stands: the model that it has, the scales in which errors are compared, and what
// was found on the way. The steps of the search (steps.h) are functions of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/diagnose/explain/regimes.h"
#include "tools/diagnose/explain/select.h"

namespace sanso::diagnose {

/// What holds between two steps, restored by relinearise():
///
///   found.accepted[i]     is the effect found.final.model.effects[i]
///   found.around          starts and nuisances, linearised at found.final.model
///   found.final, nominal  fitted there, with and without effects
///   found.*_heldout       their energies by shot, each from fits without the shot's group
struct SearchState {
  SearchState(const Problem& problem_, const Library& library_, const SelectOptions& options_)
      : problem(problem_), library(library_), options(options_), regimes(find_regimes(*problem_)) {}

  Problem problem;  // its scales, correction and starts follow the model
  const Library& library;
  const SelectOptions& options;
  const Regimes regimes;  // of the recorded motion
  Selection found;
  // lost commands that scatter alone speaks for: none of them could be pointed at
  std::optional<std::size_t> unpointed;
  // candidates that their own residual contradicted, or of which not even a part was needed, or
  // that left twice beside others
  std::vector<std::size_t> given_up;
  std::vector<std::size_t> left_once;  // candidates that others made superfluous

  const DecisionSettings& decisions() const { return problem->settings.decisions; }
  const Candidate& candidate(std::size_t i) const { return library[i]; }
  /// The candidate that is accepted at place i.
  const Candidate& accepted(std::size_t i) const { return candidate(found.accepted[i].candidate); }
  /// Candidates that the model does not have.
  std::vector<std::size_t> open() const;
  /// Of these, those that were not given up: what a step asks.
  std::vector<std::size_t> asked() const;

  /// Energy that an effect of the smallest size that matters removes.
  double practical() const { return practical_energy(*problem); }
  /// Held-out energy of the nominal model: the whole that shares are taken of.
  double whole() const;
  /// Noise levels in the position error, `scatter` explained by chance.
  double left_level(const Eigen::VectorXd& scatter) const;

  void say(const std::string& text);
  /// Channels to the error levels that a screening found, and everything that depends on them.
  void calibrate(const Screening& screening);
  /// Starts and nuisances at the current model; its fit polished there, the nominal model's too.
  void relinearise();
  /// The model less the effect at place `index`, everything else refitted; the second without
  /// derivatives.
  FitResult without(std::size_t index) const;
  FitResult rough_without(std::size_t index) const;
  /// Beside others it is not needed any more; a search that asks it a third time goes around.
  void leaves(std::size_t candidate);
  /// Takes that effect out; `reduced`: the fit without it.
  void drop(std::size_t index, FitResult reduced);

  /// By shot: which occurrence of an effect that acts at one instant it belongs to, one a
  /// recording; or none.
  std::vector<std::optional<std::size_t>> occurrences(const Chosen& effect) const;
  /// What `effect` removes on held-out shots.
  HeldoutGain gain_of(const Chosen& effect, const Eigen::VectorXd& without,
                      const Eigen::VectorXd& with) const;
  /// The residual that what `with` adds to `without` should have changed and did not; empty: none.
  std::string residual_against(const FitResult& without, const FitResult& with) const;
};

/// A step asks as many candidates as are fitted, and the luckiest is accepted first: the level is
/// theirs together (Bonferroni). The bootstrap's quantiles do not reach so far out; they are
/// stretched as the normal's.
bool beyond_chance_of_many(const DecisionSettings& decisions, const HeldoutGain& gain);

/// Beside the dry friction that the model has the alternative says how that builds up, and no more.
bool only_how_it_builds_up(const SearchState& state, const Alternative& a);

/// Empty when the alternative may be accepted over the current model; else the gate that it fails.
std::string refused_by(const SearchState& state, const Alternative& a);

/// Conditions left out as a whole are predicted no worse than by the current model.
bool holds_on_conditions(const SearchState& state, const Alternative& a);

}  // namespace sanso::diagnose
