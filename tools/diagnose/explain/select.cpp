// The search from its first screening to intervals. In the code's own names, for stacked errors r
// whitened by channel:
//
//   E(model) = sum over shots rho(r'Mr) + sum (nuisance / tolerance)^2       what a fit minimises
//   M        takes out every shot's start (StartElimination)
//   gain     = E without the effect - E with it, on shots whose group was left out of both fits
//
// A name is accepted for its gain, its interval and its residuals, never for E on what it was
// fitted to.
#include "tools/diagnose/explain/select.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>

#include "tools/diagnose/explain/instants.h"
#include "tools/diagnose/explain/steps.h"

namespace sanso::diagnose {
namespace {

std::string error_levels(const Problem& problem) {
  std::string text;
  for (std::size_t c = 0; c < problem->channels.size(); ++c) {
    const Observed& channel = problem->channels[c];
    text += fmt::format("{}{}:{} {:.2g}", text.empty() ? "" : ", ", to_string(channel.signal),
                        problem->joints[channel.joint], problem.scales.sigma[c]);
  }
  return text;
}

/// The first screening, of the nominal model; channels to the error levels that it finds.
void start(SearchState& state) {
  Selection& found = state.found;
  state.problem = step_corrected(state.problem, state.library, Model{});
  found.around = make_surroundings(state.problem, state.library, Model{});
  const std::vector<std::size_t> all = state.open();
  const Eigen::VectorXd r = prediction_error(state.problem, state.library, Model{});
  found.around->set_shot_scale(found.around->starts.energy_by_shot(r));
  found.first = screen(*found.around, Model{}, r, all, Random(state.options.seed, 1), nullptr, {},
                       state.options.keep_groups);
  state.calibrate(found.first);
  state.say(fmt::format(
      "screened {} candidates ({} signatures), error level {}, critical score {:.2f}", all.size(),
      found.first.probes.size(), error_levels(state.problem), found.first.critical));
}

/// How much more than noise is left, in the directions of the candidates that are not named.
double left_over(const SearchState& state) {
  const Selection& found = state.found;
  return screen(*found.around, found.final.model, found.final.r, state.open(),
                Random(state.options.seed, 2), &found.first)
      .mean_square();
}

/// Steps forward as long as a name passes; `step` counts all of them. True: one did.
bool go_forward(SearchState& state, int& step) {
  const int before = step, most = state.decisions().maximum_effects;
  while (step < before + most && std::cmp_less(state.found.accepted.size(), most)) {
    const Forward went = forward(state, step++);
    if (went == Forward::none) return step > before + 1;
    place_instants_anew(state);
    if (state.found.accepted.size() > 1) backward(state, 1);
    untie(state);
    state.options.reached(state.found);
    if (went == Forward::ended) break;
  }
  return step > before;
}

/// Names against what else could stand in their places, and against their own residuals. True: one
/// took another's place, or left its own.
bool settle(SearchState& state) {
  const bool simpler = simplify(state);
  one_for_two(state);
  two_for_one(state);
  const bool swapped = swap_for_better(state) || simpler;
  place_instants_anew(state);
  const bool refuted = drop_refuted(state);
  describe_what_going_on_beats(state);
  state.options.reached(state.found);
  return swapped || refuted;
}

/// The last name that another is level with, and the first of these.
struct LookAlike {
  std::size_t place;
  Alternative other;
};
std::optional<LookAlike> look_alike(const SearchState& state) {
  const Selection& found = state.found;
  for (std::size_t i = found.accepted.size(); i-- > 0;) {
    if (state.accepted(i).random) continue;
    const std::vector<Alternative>& others = found.accepted[i].alternatives;
    for (const Alternative& a : others) {
      const bool level = !a.far_behind && !found.final.model.has(a.candidate) &&
                         a.fit.model.effects.size() == found.final.model.effects.size() &&
                         !beaten(state.decisions(), a.behind, state.practical(), others.size());
      if (level && !at_bound(state.library, a)) return LookAlike{i, a};
    }
  }
  return std::nullopt;
}

/// Which of two level names stands is chance, and what passes beside one may fail beside the other
/// by a hair. Where more than noise is left it is asked beside the other too, once. True: something
/// passed.
bool go_on_from_look_alike(SearchState& state, int& step) {
  if (state.left_level({}) <= state.decisions().adequate) return false;
  std::optional<LookAlike> other = look_alike(state);
  if (!other) return false;
  const Problem problem = state.problem;
  const std::vector<std::size_t> given_up = state.given_up;
  Selection found = state.found;
  take_place(state, other->place, other->other);
  if (go_forward(state, step)) return true;
  state.say("nothing more passes beside " + state.candidate(other->other.candidate).title());
  state.problem = problem;
  state.given_up = given_up;
  found.log = std::move(state.found.log);
  state.found = std::move(found);
  return false;
}

/// Exchanges of names and further steps in turn: a name that took another's place leaves something
/// else, and one that was refuted stood for it.
void exchange_and_go_on(SearchState& state, int& step) {
  bool asked_beside = false;
  for (int round = 0;; ++round) {
    const bool changed = settle(state);
    if (round >= state.decisions().rounds) return;
    if (!changed && std::exchange(asked_beside, true)) return;
    if (!(changed ? go_forward(state, step) : go_on_from_look_alike(state, step))) return;
  }
}

/// Intervals of the final model, and every effect's gain with all others in place.
void finish(SearchState& state) {
  Selection& found = state.found;
  Eigen::MatrixXd by_instants;
  if (!found.accepted.empty()) {
    const double inflation = left_over(state);
    by_instants = spread_of_instants(*found.around, found.final, inflation);
    found.final.covariance = robust_covariance(*found.around, found.final, inflation) + by_instants;
  }
  for (Accepted& entry : found.accepted) {
    if (entry.candidate == state.unpointed)
      entry.contradicted = "no lost command could be pointed at, scatter alone speaks for them";
  }
  for (std::size_t i = 0; i < found.accepted.size(); ++i) follow_level_rivals(state, i);
  const std::vector<double> sigma = parameter_sigmas(found.final, state.library);
  std::size_t next = 0;
  for (std::size_t i = 0; i < found.accepted.size(); ++i) {
    Accepted& entry = found.accepted[i];
    const std::size_t count = state.accepted(i).parameters.size();
    for (std::size_t k = 0; k < count; ++k, ++next) {
      const CandidateParameter& p = state.accepted(i).parameters[k];
      const auto at = static_cast<Eigen::Index>(next);
      entry.sigma.push_back(p.structural ? p.typical * std::sqrt(by_instants(at, at))
                                         : sigma[next]);
      entry.at_bound.push_back(found.final.fixed[next]);
    }
    entry.without = found.accepted.size() == 1 ? found.nominal : state.without(i);
    entry.gain = state.gain_of(found.final.model.effects[i],
                               heldout_energy(*found.around, entry.without), found.final_heldout);
    entry.without.J.resize(0, 0);
  }
}

}  // namespace

Selection select(const Problem& problem, const Library& library, const SelectOptions& options) {
  SearchState state(problem, library, options);
  start(state);
  options.reached(state.found);
  int step = 0;
  go_forward(state, step);
  exchange_and_go_on(state, step);
  // chance scatters what the other names were judged by, and hid smaller ones
  if (judge_chance(state)) {
    go_forward(state, step);
    settle(state);
  }
  finish(state);
  return std::move(state.found);
}

}  // namespace sanso::diagnose
