// What keeps a search's state consistent, and the gates that a name has to pass.
#include "tools/diagnose/explain/search_state.h"

#include <algorithm>

#include "tools/diagnose/explain/events.h"
#include "tools/diagnose/explain/incidence.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

/// What acts at one instant only has to explain that instant: any blow takes something from any
/// jerk.
bool settles_its_event(const SearchState& state, const Alternative& a) {
  const std::vector<std::optional<std::size_t>> occurrence =
      state.occurrences(a.fit.model.effects.back());
  const auto energy = [&](const Eigen::VectorXd& r) {
    double sum = 0.0;
    for (const Event& e : find_events(state.problem, state.found.around->starts.project(r)))
      sum += occurrence[e.shot] ? e.excess : 0.0;
    return sum;
  };
  return energy(a.fit.r) <= state.decisions().minimum_share * energy(state.found.final.r);
}

}  // namespace

std::vector<std::size_t> SearchState::open() const {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < library.candidates.size(); ++i) {
    if (!found.final.model.has(i)) out.push_back(i);
  }
  return out;
}

std::vector<std::size_t> SearchState::asked() const {
  std::vector<std::size_t> out = open();
  std::erase_if(out, [&](std::size_t c) {
    return std::find(given_up.begin(), given_up.end(), c) != given_up.end();
  });
  return out;
}

double SearchState::whole() const { return std::max(found.nominal_heldout.sum(), 1e-9); }

double SearchState::left_level(const Eigen::VectorXd& scatter) const {
  return position_error_level(*found.around, found.final.r, scatter);
}

void SearchState::say(const std::string& text) {
  found.log.push_back(text);
  options.progress(text);
}

void SearchState::calibrate(const Screening& screening) {
  if (found.expected_scatter.size() > 0) {  // squares, in the units of the scales
    const Eigen::VectorXd spread = found.expected_scatter.cwiseSqrt();
    found.expected_scatter =
        rescaled(*problem, spread, problem.scales, screening.scales).cwiseAbs2();
  }
  problem.scales = screening.scales;
  relinearise();
}

void SearchState::relinearise() {
  problem = step_corrected(problem, library, found.final.model);
  found.around = make_surroundings(problem, library, found.final.model);
  found.around->set_shot_scale(
      found.around->starts.energy_by_shot(prediction_error(problem, library, found.final.model)));
  found.final = fit(*found.around, found.final.model, problem->settings.fitting.steps_anew);
  found.nominal = found.accepted.empty()
                      ? found.final
                      : fit(*found.around, Model{{}, found.nominal.model.nuisance}, 1);
  found.nominal_heldout = heldout_energy(*found.around, found.nominal);
  found.final_heldout = heldout_energy(*found.around, found.final);
}

FitResult SearchState::without(std::size_t index) const {
  return resume(*found.around, rough_without(index), 0);
}

FitResult SearchState::rough_without(std::size_t index) const {
  Model model = found.final.model;
  model.effects.erase(model.effects.begin() + static_cast<std::ptrdiff_t>(index));
  return rough_fit(*found.around, model, problem->settings.fitting.steps_without);
}

void SearchState::leaves(std::size_t candidate) {
  const bool before = std::find(left_once.begin(), left_once.end(), candidate) != left_once.end();
  (before ? given_up : left_once).push_back(candidate);
}

void SearchState::drop(std::size_t index, FitResult reduced) {
  found.accepted.erase(found.accepted.begin() + static_cast<std::ptrdiff_t>(index));
  found.final = std::move(reduced);
  relinearise();
}

std::vector<std::optional<std::size_t>> SearchState::occurrences(const Chosen& effect) const {
  const Candidate& c = candidate(effect.candidate);
  std::vector<std::optional<std::size_t>> out(problem->shots.size());
  for (std::size_t p = 0; p < c.parameters.size(); ++p) {
    if (c.parameters[p].role != Role::event) continue;
    for (std::size_t s = 0; s < out.size(); ++s) {
      const Shot& shot = problem->shots[s];
      if (near_instant(*problem, shot, effect.theta[p])) out[s] = shot.source;
    }
  }
  return out;
}

HeldoutGain SearchState::gain_of(const Chosen& effect, const Eigen::VectorXd& without,
                                 const Eigen::VectorXd& with) const {
  return compare(*problem, without, with, occurrences(effect));
}

std::string SearchState::residual_against(const FitResult& without, const FitResult& with) const {
  return refuted_by(incidence(*found.around, regimes, without, with), decisions());
}

bool beyond_chance_of_many(const DecisionSettings& decisions, const HeldoutGain& gain) {
  const double asked = std::max(1, decisions.rivals + decisions.pairs);
  const double level = decisions.gain_level / kGainMeasures;
  const double stretch = normal_score(level / asked) / normal_score(level);
  const auto sure = [stretch](const Paired& p) {
    return p.total - stretch * (p.total - p.lower) > 0.0;
  };
  return sure(gain.energy) || sure(gain.bounded) || sure(gain.ranks);
}

bool only_how_it_builds_up(const SearchState& state, const Alternative& a) {
  const std::vector<Accepted>& accepted = state.found.accepted;
  return std::any_of(accepted.begin(), accepted.end(), [&](const Accepted& entry) {
    return says_as_much(*state.problem, state.library, entry.candidate, a);
  });
}

std::string refused_by(const SearchState& state, const Alternative& a) {
  const Selection& found = state.found;
  const HeldoutGain gain =
      state.gain_of(a.fit.model.effects.back(), found.final_heldout, a.heldout);
  if (!beyond_chance_of_many(state.decisions(), gain))
    return "held-out gain not beyond the chance of so many candidates";
  if (gain.removed() < state.practical()) return "changes predictions by less than what matters";
  if (gain.removed() < state.decisions().minimum_share * found.final_heldout.sum())
    return "removes less than 1 % of what is left";
  if (!leaves_null(state.decisions(), state.library, a)) return "interval contains the null";
  if (only_how_it_builds_up(state, a))
    return "says how dry friction builds up, which nobody states";
  if (!holds_on_conditions(state, a)) return "worse on conditions left out";
  if (!settles_its_event(state, a)) return "leaves errors far above noise at its instant";
  return "";
}

bool holds_on_conditions(const SearchState& state, const Alternative& a) {
  if (state.problem->conditions < 2) return true;
  const Surroundings& around = *state.found.around;
  const HeldoutGain gain =
      compare(state.decisions(), heldout_energy(around, state.found.final, true),
              heldout_energy(around, a.fit, true));
  return gain.bounded.total > -gain.bounded.standard_error;
}

}  // namespace sanso::diagnose
