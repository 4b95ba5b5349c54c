// Pairs judged as pairs: both are fitted at once, both have to be needed beside the other, and what
// they promise together must have happened.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/explain/steps.h"
#include "tools/diagnose/fit/pairs.h"
#include "tools/diagnose/fit/start.h"

namespace sanso::diagnose {
namespace {

struct FittedPair {
  CandidatePair pair;
  FitResult fit;  // the pair stands last in its model
  Eigen::VectorXd heldout;
};

/// One of them alone, fitted fully, leaves next to nothing more: the other is not needed, and what
/// proves it on held-out groups costs more than the fits.
bool as_good_alone(const SearchState& state, const FittedPair& f,
                   const std::vector<Alternative>& singles) {
  return std::any_of(singles.begin(), singles.end(), [&](const Alternative& a) {
    const bool member =
        a.candidate == f.pair.first.candidate || a.candidate == f.pair.second.candidate;
    return member && a.fit.objective - f.fit.objective < state.practical();
  });
}

/// Best first; without those that need not both be there.
std::vector<FittedPair> fit_pairs(const SearchState& state, const std::vector<CandidatePair>& pairs,
                                  const std::vector<Alternative>& singles) {
  const Surroundings& around = *state.found.around;
  const FittingSettings& fitting = around.settings().fitting;
  std::vector<FittedPair> out(pairs.size());
  if (pairs.empty()) return out;
  const Surroundings some = some_shots(around, state.found.final.model);
  parallel_for(pairs.size(), [&](std::size_t i) {
    FittedPair& f = out[i];
    f.pair = pairs[i];
    f.fit = rough_fit(around,
                      best_start(some, state.found.final.model, pairs[i].first, pairs[i].second),
                      fitting.first_iterations);
  });
  double best = INFINITY;
  for (const FittedPair& f : out) best = std::min(best, f.fit.objective);
  const double near =
      best + fitting.polish_share * std::max(0.0, state.found.final.objective - best);
  std::erase_if(out, [near](const FittedPair& f) { return f.fit.objective > near; });
  parallel_for(out.size(), [&](std::size_t i) {
    const int left = out[i].fit.converged ? 0 : fitting.iterations - fitting.first_iterations;
    out[i].fit = resume(around, std::move(out[i].fit), left);
  });
  std::erase_if(out, [&](const FittedPair& f) { return as_good_alone(state, f, singles); });
  parallel_for(out.size(),
               [&](std::size_t i) { out[i].heldout = heldout_energy(around, out[i].fit); });
  double unit = INFINITY;
  for (const FittedPair& f : out) unit = std::min(unit, typical_energy(f.heldout));
  std::stable_sort(out.begin(), out.end(), [unit](const FittedPair& a, const FittedPair& b) {
    return bounded_energy(a.heldout, unit) < bounded_energy(b.heldout, unit);
  });
  return out;
}

/// The pair less the effect at place `i`, everything refitted from where the pair has it.
Alternative alone(const SearchState& state, const FittedPair& f, std::size_t i) {
  const Surroundings& around = *state.found.around;
  Model other = f.fit.model;
  other.effects.erase(other.effects.begin() + static_cast<std::ptrdiff_t>(i));
  Alternative out;
  out.candidate = other.effects.back().candidate;
  out.fit = fit(around, other, around.settings().fitting.iterations);
  out.heldout = heldout_energy(around, out.fit);
  return out;
}

/// No gate and no residual speaks against a single name.
bool stands(const SearchState& state, const Alternative& a) {
  return !at_bound(state.library, a) && refused_by(state, a).empty() &&
         state.residual_against(state.found.final, a.fit).empty();
}

/// Why the effect at place `i` of the pair's model is no part of it; empty: nothing. Its gain is
/// that over the other one alone (`other`), and the luckiest of as many as for a single name.
std::string refused_at(const SearchState& state, const FittedPair& f, std::size_t i,
                       const Alternative& other) {
  const DecisionSettings& decisions = state.decisions();
  const std::string title = state.library[f.fit.model.effects[i]].title();
  if (at_bound(state.library, f.fit, i)) return title + " ends at a bound";
  if (!leaves_null(decisions, state.library, f.fit, i)) return title + " may be nothing";
  const HeldoutGain gain = state.gain_of(f.fit.model.effects[i], other.heldout, f.heldout);
  const bool needed = beyond_chance_of_many(decisions, gain) &&
                      gain.removed() > state.practical() &&
                      gain.removed() > decisions.minimum_share * other.heldout.sum();
  if (!needed) return title + " is not needed beside the other";
  return state.residual_against(other.fit, f.fit);
}

/// Its own fit, among `singles`, ended in another hollow, far above where the pair has it.
bool was_lost(const Alternative& a, const std::vector<Alternative>& singles) {
  return std::any_of(singles.begin(), singles.end(), [&a](const Alternative& own) {
    return own.candidate == a.candidate && own.fit.objective > a.fit.objective + kNoiseUnit;
  });
}

/// `single`: one of them alone, where its own fit was lost and it stands by itself after all, with
/// or without need of the other: whether that is missing too is asked of the step after.
std::string refused_by(const SearchState& state, const FittedPair& f,
                       const std::vector<Alternative>& singles,
                       std::optional<Alternative>& single) {
  const std::size_t last = f.fit.model.effects.size() - 1;
  Alternative both;
  both.candidate = f.fit.model.effects[last].candidate;
  both.fit = f.fit;
  both.heldout = f.heldout;
  if (std::string gate = refused_by(state, both); !gate.empty()) return gate;
  if (std::string residual = state.residual_against(state.found.final, f.fit); !residual.empty())
    return residual;
  for (const std::size_t i : {last - 1, last}) {
    Alternative other = alone(state, f, i);
    std::string why = refused_at(state, f, i, other);
    const bool found_again = was_lost(other, singles) && stands(state, other);
    if (!why.empty()) {
      single.reset();
      if (found_again) single = std::move(other);
      return why;
    }
    const bool better = !single || bounded_energy(other.heldout, typical_energy(f.heldout)) <
                                       bounded_energy(single->heldout, typical_energy(f.heldout));
    if (better && found_again) single = std::move(other);
  }
  return "";
}

void accept(SearchState& state, FittedPair f) {
  for (const ProbeScore& of : {f.pair.first, f.pair.second}) {
    Accepted entry;
    entry.candidate = of.candidate;
    entry.p_family = f.pair.p;
    state.found.accepted.push_back(std::move(entry));
  }
  const bool as_told = f.fit.model.effects.back().candidate == f.pair.second.candidate;
  if (!as_told) std::swap(state.found.accepted.back(), *(state.found.accepted.end() - 2));
  state.found.final = std::move(f.fit);
  state.relinearise();
}

void accept_single(SearchState& state, const FittedPair& f, Alternative single) {
  Accepted entry;
  entry.candidate = single.candidate;
  entry.p_family = f.pair.p;
  state.say(state.candidate(entry.candidate).title() + " stands alone from where the pair has it");
  state.found.accepted.push_back(std::move(entry));
  state.found.final = std::move(single.fit);
  state.relinearise();
}

}  // namespace

bool accept_pair(SearchState& state, int step, const Screening& screening,
                 const std::vector<Alternative>& singles, double least_energy) {
  if (state.found.accepted.size() + 2 > static_cast<std::size_t>(state.decisions().maximum_effects))
    return false;
  const std::vector<CandidatePair> promising =
      promising_pairs(state.problem->settings, state.library, screening, least_energy);
  for (FittedPair& f : fit_pairs(state, promising, singles)) {
    std::optional<Alternative> single;
    const std::string refused = refused_by(state, f, singles, single);
    const HeldoutGain gain = compare(*state.problem, state.found.final_heldout, f.heldout);
    state.say(fmt::format(
        "step {}: {} and {} together: held-out gain {:.1f} % of the error (at least {:.1f}; "
        "bounded {:.1f}, at least {:.1f}){}",
        step + 1, state.candidate(f.pair.first.candidate).title(),
        state.candidate(f.pair.second.candidate).title(), 100 * gain.removed() / state.whole(),
        100 * gain.energy.lower / state.whole(), 100 * gain.bounded.total / gain.whole,
        100 * gain.bounded.lower / gain.whole,
        refused.empty() ? ", accepted" : ", refused: " + refused));
    if (!refused.empty() && !single) continue;
    if (single)
      accept_single(state, f, std::move(*single));
    else
      accept(state, std::move(f));
    return true;
  }
  return false;
}

}  // namespace sanso::diagnose
