// Two names in the place of one that needs many more numbers. A step that finds neither of two
// missing effects worth its gates alone takes the one name that can say what both do: a payload
// for a mass and an encoder's zero.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/explain/steps.h"
#include "tools/diagnose/fit/pairs.h"
#include "tools/diagnose/fit/start.h"

namespace sanso::diagnose {
namespace {

/// What describes an effect: its numbers, and which effect it is. Of one cause and two, the one is
/// likelier.
int described_by(const Candidate& c) { return free_parameters(c) + 1; }

/// Where the one stands, or at the robot as a whole.
bool at_its_place(const Candidate& other, const Candidate& own) {
  return other.joints.empty() || other.joints == own.joints;
}

Model without(const Model& model, std::size_t i) {
  Model out = model;
  out.effects.erase(out.effects.begin() + static_cast<std::ptrdiff_t>(i));
  return out;
}

/// The pair that leaves least in place of the i-th effect.
std::optional<FitResult> best_pair(const SearchState& state, std::size_t i) {
  const Candidate& own = state.accepted(i);
  const Model base = without(state.found.final.model, i);
  const std::vector<CandidatePair> pairs = pairs_in_place_of(
      state.problem->settings, state.library, state.found.first, state.found.accepted[i].candidate,
      [&own](const Candidate& a, const Candidate& b) {
        return at_its_place(a, own) && at_its_place(b, own) &&
               described_by(a) + described_by(b) < described_by(own);
      });
  if (pairs.empty()) return std::nullopt;
  const Surroundings& around = *state.found.around;
  const FittingSettings& fitting = around.settings().fitting;
  const Surroundings some = some_shots(around, base);
  std::vector<FitResult> fits(pairs.size());
  parallel_for(pairs.size(), [&](std::size_t k) {
    const CandidatePair& pair = pairs[k];
    if (base.has(pair.first.candidate) || base.has(pair.second.candidate)) return;
    fits[k] =
        rough_fit(around, best_start(some, base, pair.first, pair.second), fitting.iterations);
  });
  std::erase_if(fits, [](const FitResult& f) { return f.model.effects.empty(); });
  if (fits.empty()) return std::nullopt;
  const auto best = std::min_element(
      fits.begin(), fits.end(),
      [](const FitResult& a, const FitResult& b) { return a.objective < b.objective; });
  return resume(around, std::move(*best), 0);
}

/// Nothing speaks against the pair, and the one does not predict better.
bool stands(const SearchState& state, std::size_t i, const FitResult& pair) {
  const std::size_t last = pair.model.effects.size() - 1;
  for (const std::size_t k : {last - 1, last}) {
    if (at_bound(state.library, pair, k) || !leaves_null(state.decisions(), state.library, pair, k))
      return false;
  }
  Alternative both;
  both.candidate = pair.model.effects.back().candidate;
  both.fit = pair;
  both.heldout = heldout_energy(*state.found.around, pair);
  const HeldoutGain lost = compare(*state.problem, both.heldout, state.found.final_heldout);
  return !beaten(state.decisions(), lost, state.practical()) && holds_on_conditions(state, both) &&
         state.residual_against(state.rough_without(i), pair).empty();
}

void take_its_place(SearchState& state, std::size_t i, FitResult pair) {
  std::vector<Accepted>& accepted = state.found.accepted;
  const double p_family = accepted[i].p_family;
  const std::string title = state.accepted(i).title();
  accepted.erase(accepted.begin() + static_cast<std::ptrdiff_t>(i));
  const std::size_t last = pair.model.effects.size() - 1;
  for (const std::size_t k : {last - 1, last}) {
    Accepted entry;
    entry.candidate = pair.model.effects[k].candidate;
    entry.p_family = p_family;
    accepted.push_back(std::move(entry));
  }
  state.say(fmt::format("{} and {} in the place of {}", state.accepted(last - 1).title(),
                        state.accepted(last).title(), title));
  state.found.final = std::move(pair);
  state.relinearise();
}

}  // namespace

void two_for_one(SearchState& state) {
  bool changed = false;
  for (std::size_t i = 0; i < state.found.accepted.size();) {
    const bool room = std::cmp_less(state.found.accepted.size(), state.decisions().maximum_effects);
    std::optional<FitResult> pair;
    if (room && !state.accepted(i).random) pair = best_pair(state, i);
    if (!pair || !stands(state, i, *pair)) {
      ++i;
      continue;
    }
    take_its_place(state, i, std::move(*pair));
    changed = true;
  }
  if (changed) backward(state, 0);
}

}  // namespace sanso::diagnose
