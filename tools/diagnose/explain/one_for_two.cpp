// One name in the place of two at one joint. Steps take the simpler of two that explain nearly as
// much, and then what it leaves: of a friction with two numbers, two frictions with one each.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/explain/steps.h"
#include "tools/diagnose/fit/start.h"

namespace sanso::diagnose {
namespace {

bool related(const Candidate& a, const Candidate& b) {
  return documented_twin(a.effect, b.effect) || documented_twin(b.effect, a.effect);
}

/// May say what both say, with no more numbers than they have together.
bool may_be_both(const Candidate& one, const Candidate& a, const Candidate& b) {
  const bool names_something = !one.random && !a.random && !b.random && !one.joints.empty();
  return names_something && a.joints == b.joints && one.joints == a.joints && related(one, a) &&
         related(one, b) && free_parameters(one) <= free_parameters(a) + free_parameters(b);
}

/// Fitted in their place; nothing where a gate speaks against it or they predict better.
std::optional<Alternative> fit_for_both(const SearchState& state, std::size_t a, std::size_t b,
                                        std::size_t candidate) {
  const Surroundings& around = *state.found.around;
  Model base = state.found.final.model;
  base.effects.erase(base.effects.begin() + static_cast<std::ptrdiff_t>(std::max(a, b)));
  base.effects.erase(base.effects.begin() + static_cast<std::ptrdiff_t>(std::min(a, b)));
  Alternative one;
  one.candidate = candidate;
  one.fit = fit(around, best_start(around, base, candidate, state.found.first.best(candidate)),
                around.settings().fitting.iterations);
  if (at_bound(state.library, one) || !leaves_null(state.decisions(), state.library, one) ||
      says_no_more(*state.problem, state.library, one))
    return std::nullopt;
  one.heldout = heldout_energy(around, one.fit);
  const HeldoutGain lost = compare(*state.problem, one.heldout, state.found.final_heldout);
  if (beaten(state.decisions(), lost, state.practical()) || !holds_on_conditions(state, one))
    return std::nullopt;
  return one;
}

void take_their_place(SearchState& state, std::size_t a, std::size_t b, const Alternative& one) {
  std::vector<Accepted>& accepted = state.found.accepted;
  state.say(fmt::format("{} in the place of {} and {}", state.candidate(one.candidate).title(),
                        state.accepted(a).title(), state.accepted(b).title()));
  Accepted entry;
  entry.candidate = one.candidate;
  entry.p_family = std::max(accepted[a].p_family, accepted[b].p_family);
  accepted.erase(accepted.begin() + static_cast<std::ptrdiff_t>(std::max(a, b)));
  accepted.erase(accepted.begin() + static_cast<std::ptrdiff_t>(std::min(a, b)));
  accepted.push_back(std::move(entry));
  state.found.final = one.fit;
  state.relinearise();
}

/// True when a name took the place of two.
bool replace_two(SearchState& state) {
  const std::size_t count = state.found.accepted.size();
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = a + 1; b < count; ++b) {
      for (const std::size_t c : state.open()) {
        if (!may_be_both(state.candidate(c), state.accepted(a), state.accepted(b))) continue;
        const std::optional<Alternative> one = fit_for_both(state, a, b, c);
        if (!one) continue;
        take_their_place(state, a, b, *one);
        return true;
      }
    }
  }
  return false;
}

}  // namespace

void one_for_two(SearchState& state) {
  while (replace_two(state)) {
  }
}

}  // namespace sanso::diagnose
