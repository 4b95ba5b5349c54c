// Names that leave again: not needed beside the others, tied where they should not be, or
// contradicted by their own residual.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "tools/diagnose/explain/steps.h"
#include "tools/diagnose/explain/untie.h"

namespace sanso::diagnose {
namespace {

/// The untied effects in the place of the tied ones.
void replace(SearchState& state, const Untied& u, FitResult apart) {
  std::vector<Accepted>& accepted = state.found.accepted;
  double p_family = 0.0;
  for (const std::size_t i : u.replaced) p_family = std::max(p_family, accepted[i].p_family);
  std::vector<Accepted> kept;
  for (const std::size_t i : u.stay) kept.push_back(std::move(accepted[i]));
  for (std::size_t i = u.stay.size(); i < u.model.effects.size(); ++i) {
    Accepted entry;
    entry.candidate = u.model.effects[i].candidate;
    entry.p_family = p_family;
    kept.push_back(std::move(entry));
  }
  accepted = std::move(kept);
  state.found.final = std::move(apart);
  state.relinearise();
}

}  // namespace

void backward(SearchState& state, std::size_t just_judged) {
  Selection& found = state.found;
  for (std::size_t i = 0; i + just_judged < found.accepted.size();) {
    if (state.accepted(i).random) {  // needed for the scatter, whatever its mean gains
      ++i;
      continue;
    }
    FitResult reduced = state.without(i);
    const Eigen::VectorXd without = heldout_energy(*found.around, reduced);
    const HeldoutGain gain =
        state.gain_of(found.final.model.effects[i], without, found.final_heldout);
    const bool needed = gain.beyond_chance() && gain.removed() > state.practical() &&
                        gain.removed() > state.decisions().minimum_share * without.sum();
    if (needed) {
      ++i;
      continue;
    }
    state.say("no longer needed: " + state.accepted(i).title());
    state.leaves(found.accepted[i].candidate);
    state.drop(i, std::move(reduced));
  }
}

void untie(SearchState& state) {
  const Model& tied = state.found.final.model;
  for (const Untied& u : untied(state.library, tied, state.decisions().maximum_effects)) {
    std::optional<FitResult> apart = fit_untied(*state.found.around, u, state.found.final);
    state.say(fmt::format("untie {}: {}",
                          state.candidate(tied.effects[u.replaced.front()].candidate).title(),
                          apart ? "accepted" : "refused, predicts worse"));
    if (!apart) continue;
    replace(state, u, std::move(*apart));
    backward(state, 0);
    return;
  }
}

bool drop_refuted(SearchState& state) {
  Selection& found = state.found;
  bool dropped = false;
  for (std::size_t i = 0; i < found.accepted.size();) {
    if (state.accepted(i).random) {  // it promises scatter, and no change of a residual
      ++i;
      continue;
    }
    FitResult reduced = state.rough_without(i);
    const std::string refuted = state.residual_against(reduced, found.final);
    if (refuted.empty()) {
      ++i;
      continue;
    }
    const std::string title = state.accepted(i).title();
    reduced = resume(*found.around, std::move(reduced), 0);
    const Eigen::VectorXd energy = heldout_energy(*found.around, reduced);
    if (compare(*state.problem, energy, found.final_heldout).removed() >
        state.decisions().stand_in_share * energy.sum()) {
      state.say("contradicted, kept as a description: " + title + ", " + refuted);
      found.accepted[i].contradicted = refuted;
      ++i;
      continue;
    }
    state.say("refuted: " + title + ", " + refuted);
    found.refuted.push_back(title + " (" + refuted + ")");
    state.given_up.push_back(found.accepted[i].candidate);
    state.drop(i, std::move(reduced));
    dropped = true;
    for (Accepted& entry : found.accepted) entry.contradicted.clear();
    i = 0;
  }
  return dropped;
}

}  // namespace sanso::diagnose
