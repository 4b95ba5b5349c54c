// Friction that builds up over less than anybody states leaves its place to the dry friction that
// it contains. While other names were missing it may have looked larger, so it is asked at the
// end.
#include <algorithm>
#include <optional>
#include <vector>

#include "tools/diagnose/explain/steps.h"
#include "tools/diagnose/fit/start.h"

namespace sanso::diagnose {
namespace {

std::optional<std::size_t> accepted_already(const SearchState& state, const Candidate& larger) {
  for (const Accepted& entry : state.found.accepted) {
    if (contains(larger, state.candidate(entry.candidate))) return entry.candidate;
  }
  return std::nullopt;
}

std::optional<std::size_t> contained_in(const SearchState& state, const Candidate& larger) {
  for (const std::size_t c : state.open()) {
    if (contains(larger, state.candidate(c))) return c;
  }
  return std::nullopt;
}

/// Fitted in place of the i-th effect, and put there.
void take_its_place(SearchState& state, std::size_t i, std::size_t simple) {
  Selection& found = state.found;
  const Surroundings& around = *found.around;
  Model base = found.final.model;
  base.effects.erase(base.effects.begin() + static_cast<std::ptrdiff_t>(i));
  Model model = fit(around, best_start(around, base, simple, found.first.best(simple)),
                    around.settings().fitting.iterations)
                    .model;
  std::rotate(model.effects.begin() + static_cast<std::ptrdiff_t>(i), model.effects.end() - 1,
              model.effects.end());
  found.final.model = std::move(model);
  found.accepted[i].candidate = simple;
  found.accepted[i].alternatives.clear();
  state.relinearise();
}

/// A name that said no more than what took its place.
struct Simplified {
  std::size_t larger, simple;
};

/// What left or gave its place away; none: nothing did.
std::optional<Simplified> simplify_one(SearchState& state) {
  const Selection& found = state.found;
  for (std::size_t i = 0; i < found.accepted.size(); ++i) {
    const Candidate& own = state.accepted(i);
    if (!says_no_more(*state.problem, state.library, found.final.model,
                      found.accepted[i].candidate))
      continue;
    const std::size_t larger = found.accepted[i].candidate;
    const std::string says = own.title() + " says how dry friction builds up, which nobody states";
    if (const std::optional<std::size_t> there = accepted_already(state, own)) {
      state.say(says);
      state.drop(i, state.without(i));
      return Simplified{larger, *there};
    }
    if (const std::optional<std::size_t> simple = contained_in(state, own)) {
      state.say(says + ": " + state.candidate(*simple).title() + " in its place");
      take_its_place(state, i, *simple);
      return Simplified{larger, *simple};
    }
  }
  return std::nullopt;
}

}  // namespace

bool simplify(SearchState& state) {
  std::vector<Simplified> all;
  while (const std::optional<Simplified> one = simplify_one(state)) all.push_back(*one);
  if (!all.empty()) backward(state, 0);
  // whose simpler part is not even needed
  for (const Simplified& one : all) {
    if (!state.found.final.model.has(one.simple)) state.given_up.push_back(one.larger);
  }
  return !all.empty();
}

}  // namespace sanso::diagnose
