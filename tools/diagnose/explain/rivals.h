// Rivals for one place of a model: which candidates are worth a full fit, their fits, and who is
// best.
#pragma once

#include <cmath>
#include <vector>

#include "tools/diagnose/fit/fit.h"
#include "tools/diagnose/fit/screen.h"

namespace sanso::diagnose {

/// A candidate that was fitted fully at one place of the model, with everything else refitted.
struct Alternative {
  std::size_t candidate = 0;
  FitResult fit;
  Eigen::VectorXd heldout;  // energy by shot
  bool far_behind = false;  // after the first steps of its fit: not polished
  HeldoutGain behind = {};  // what the best alternative gains over it
  double similarity = 0.0;  // of its signature to the chosen one's
};

/// Standard errors by which the best of several has to be ahead of one of its `rivals`. The best is
/// partly the luckiest: that some rival as good is shut out is as rare as of one rival
/// `standard_errors` make it (Bonferroni).
double errors_ahead(const DecisionSettings& settings, std::size_t rivals);
/// The best alternative predicts better than this one, of `rivals`, by more than chance and by more
/// than what matters.
bool beaten(const DecisionSettings& settings, const HeldoutGain& behind, double practical,
            std::size_t rivals = 1);

/// All that an effect of `model` says is said by what it contains: with it the joint's dry friction
/// builds up over no more than ToleranceSettings::bend.
bool says_no_more(const Comparison& comparison, const Library& library, const Model& model,
                  std::size_t candidate);
/// The same of the effect that the alternative adds.
bool says_no_more(const Comparison& comparison, const Library& library, const Alternative& a);
/// `larger` says no more, and `simple` is what it contains.
bool says_as_much(const Comparison& comparison, const Library& library, std::size_t simple,
                  const Alternative& larger);
/// It is a ripple (Role::order), and at one of its joints order times the range of all recordings
/// is less than LibrarySettings::periods: it may be a part of what bends over the angle.
bool unrepeated(const Comparison& comparison, const Candidate& candidate,
                const std::vector<double>& theta);
/// At the same place, and for some of its parameters what `simple` is.
bool contains(const Candidate& larger, const Candidate& simple);

/// Numbers that a fit of this effect may choose.
int free_parameters(const Candidate& candidate);

/// A difference of this many energy units is one unit of log-likelihood.
inline constexpr double kNoiseUnit = 2.0;

/// Energy that an effect of the smallest size that matters removes, at one joint alone.
double practical_energy(const Comparison& comparison);

/// How many are fitted for one place of a model that has `names` with it.
std::size_t most_rivals(const DecisionSettings& settings, std::size_t names);

/// What is fitted fully beside `names` others: of every cluster its simplest member that scores
/// nearly as high as its strongest, an effect once for joints that overlap; then the strongest
/// members, then the rest by score. `least_energy`: what promises less is not tried.
std::vector<std::size_t> rivals(const Settings& settings, const Library& library,
                                const Screening& screening, double least_energy,
                                std::size_t names = 0);

/// What `candidate` stood for when rivals() chose it: candidates of its cluster, and its own effect
/// at other joints, that promise enough and are not among `fitted`; strongest first, as many as
/// rivals().
std::vector<std::size_t> stood_for(const Settings& settings, const Library& library,
                                   const Screening& screening, double least_energy,
                                   std::size_t candidate, const std::vector<Alternative>& fitted,
                                   std::size_t names = 0);

/// Which candidates to try in place of an accepted one of `model`: its cluster, its known
/// confounders, what was fitted beside it.
std::vector<std::size_t> replacements(const DecisionSettings& settings, const Library& library,
                                      const Screening& first, const Model& model,
                                      std::size_t accepted, const std::vector<Alternative>& fitted);

/// Fits `base` + each of `which`, in parallel; held-out energies included. `known`: earlier fits of
/// the same candidates, to start from; what was far behind at the same (empty) base is taken as it
/// was, without derivatives.
/// `beside`: the objective of the best that was fitted to `base` before.
/// Candidates far behind after the first steps (by what the best of all removes of
/// `base_objective`) are not polished and have no derivatives, nor are groups left out of them:
/// `heldout` is then the energy of what they have seen.
std::vector<Alternative> fit_all(const Surroundings& around, const Model& base,
                                 double base_objective, const std::vector<std::size_t>& which,
                                 const Screening& screening,
                                 const std::vector<Alternative>& known = {},
                                 double beside = INFINITY);

/// Best first, in the measure of HeldoutGain; what is far behind last. Among those that the best
/// does not beat beyond chance or by something that matters, or that say all that it says, the one
/// with fewest parameters.
void rank(const Library& library, const Problem& problem, std::vector<Alternative>& all);

/// Of effect `i` of a fit: its interval excludes the null.
bool leaves_null(const DecisionSettings& settings, const Library& library, const FitResult& fit,
                 std::size_t i);
/// Of effect `i` of a fit: a parameter was stopped at a bound that is not its null.
bool at_bound(const Library& library, const FitResult& fit, std::size_t i);
/// The same two of an alternative's last effect.
bool leaves_null(const DecisionSettings& settings, const Library& library, const Alternative& a);
bool at_bound(const Library& library, const Alternative& a);

}  // namespace sanso::diagnose
