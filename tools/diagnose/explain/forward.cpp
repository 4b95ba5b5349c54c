// One more name: screen, fit the best rivals, accept the first that passes every gate.
//
//   screening     z = s'Mr / sqrt(s'Ms) of every open candidate; family-wise p over all of them
//   rivals        cluster representatives whose p and promised gain count, fitted fully
//   rank          by held-out energy, one standard error's grace for fewer parameters
//   look-alikes   of what is about to be accepted: it stood for them, and is ranked among them
//   gates         refused_by: gain, null, conditions, its instant, its residuals
//   pairs         where no single one passes: two together (together.cpp)
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "tools/diagnose/explain/steps.h"

namespace sanso::diagnose {
namespace {

void accept(SearchState& state, std::vector<Alternative> fitted, std::size_t i,
            const Screening& screening) {
  Accepted entry;
  entry.candidate = fitted[i].candidate;
  entry.p_family = screening.best(entry.candidate)->p_family;
  state.found.final = fitted[i].fit;
  fitted.erase(fitted.begin() + static_cast<std::ptrdiff_t>(i));
  for (Alternative& a : fitted) a.similarity = screening.similarity(a.candidate, entry.candidate);
  // 0.1 GB each on twelve joints, and done with
  for (Alternative& a : fitted) a.fit.J.resize(0, 0);
  entry.alternatives = std::move(fitted);
  state.found.accepted.push_back(std::move(entry));
  state.relinearise();
}

void say_judged(SearchState& state, int step, const Alternative& a, bool bounds_allowed,
                const std::string& refused) {
  const HeldoutGain gain =
      state.gain_of(a.fit.model.effects.back(), state.found.final_heldout, a.heldout);
  state.say(fmt::format(
      "step {}: {}: held-out gain {:.1f} % of the error (at least {:.1f}; bounded {:.1f}, at least "
      "{:.1f}; ranks {:.0f}, at least {:.0f}){}{}",
      step + 1, state.candidate(a.candidate).title(), 100 * gain.removed() / state.whole(),
      100 * gain.energy.lower / state.whole(), 100 * gain.bounded.total / gain.whole,
      100 * gain.bounded.lower / gain.whole, 100 * gain.ranks.total, 100 * gain.ranks.lower,
      bounds_allowed ? ", ends at a bound" : "",
      refused.empty() ? ", accepted" : ", refused: " + refused));
}

/// What stands against a name: its gates, then the residual that it should have changed.
struct Objections {
  std::string gate, residual;
};

Objections objections_to(const SearchState& state, const Alternative& a, bool at_its_bound) {
  Objections out;
  out.gate = refused_by(state, a);
  const double removed =
      state.gain_of(a.fit.model.effects.back(), state.found.final_heldout, a.heldout).removed();
  // it names nothing; a description is worth its place where it is most of what is to be said
  if (out.gate.empty() && at_its_bound &&
      removed < state.decisions().stand_in_share * state.found.final_heldout.sum())
    out.gate = "removes too little for what ends at a bound";
  if (out.gate.empty()) out.residual = state.residual_against(state.found.final, a.fit);
  return out;
}

/// The candidates of one step, best first, each judged once.
class Judged {
 public:
  Judged(SearchState& state, int step, std::vector<Alternative> fitted)
      : state_(state), step_(step), fitted_(std::move(fitted)) {
    rank(state_.library, state_.problem, fitted_);
  }

  /// The best that ends at a bound, or that does not, and passes its gates; `refutable`: no
  /// residual contradicts it either.
  std::optional<std::size_t> best(bool at_its_bound, bool refutable) {
    for (std::size_t i = 0; i < fitted_.size(); ++i) {
      if (at_bound(state_.library, fitted_[i]) != at_its_bound) continue;
      const auto [known, first_time] = objections_.try_emplace(fitted_[i].candidate);
      if (first_time) known->second = objections(fitted_[i], at_its_bound);
      const Objections& o = known->second;
      const std::string& refused = o.gate.empty() && refutable ? o.residual : o.gate;
      if (refused.empty()) return i;
      if (first_time && !hopeless(fitted_[i]))
        say_judged(state_, step_, fitted_[i], at_its_bound, refused);
    }
    return std::nullopt;
  }

  void add(std::vector<Alternative> more) {
    for (Alternative& a : more) fitted_.push_back(std::move(a));
    rank(state_.library, state_.problem, fitted_);
  }

  const std::vector<Alternative>& fitted() const { return fitted_; }
  std::vector<Alternative> take() { return std::move(fitted_); }

 private:
  /// Of what is far behind only the energy of what it was fitted to is known. Where that falls by
  /// less than a name has to remove, no group has to be left out.
  bool hopeless(const Alternative& a) const {
    const Surroundings& around = *state_.found.around;
    const double seen = around.bounded(around.starts.energy_by_shot(state_.found.final.r)).sum() -
                        around.bounded(around.starts.energy_by_shot(a.fit.r)).sum();
    const double least = std::max(
        state_.practical(), state_.decisions().minimum_share * state_.found.final_heldout.sum());
    return a.far_behind && seen < least;
  }

  Objections objections(Alternative& a, bool at_its_bound) {
    if (hopeless(a)) {
      state_.say(fmt::format("step {}: {}: removes too little of what it was fitted to", step_ + 1,
                             state_.candidate(a.candidate).title()));
      return {"removes too little of what it was fitted to", ""};
    }
    if (a.far_behind) {
      a.fit = resume(*state_.found.around, std::move(a.fit), 0);
      a.heldout = heldout_energy(*state_.found.around, a.fit);
    }
    return objections_to(state_, a, at_its_bound);
  }

  SearchState& state_;
  int step_;
  std::vector<Alternative> fitted_;
  std::map<std::size_t, Objections> objections_;  // by candidate
};

/// The screening chose one of every cluster by a linear score. What that one stood for is fitted
/// before it is accepted, and judged with it; and what the best of them stands for in its turn.
std::optional<std::size_t> best_of_its_kind(SearchState& state, int step,
                                            const Screening& screening, double least_energy,
                                            Judged& judged) {
  std::optional<std::size_t> which = judged.best(false, true);
  while (which) {
    const std::vector<std::size_t> alike =
        stood_for(state.problem->settings, state.library, screening, least_energy,
                  judged.fitted()[*which].candidate, judged.fitted(), state.found.accepted.size());
    if (alike.empty()) return which;
    const std::size_t stood = judged.fitted()[*which].candidate;
    judged.add(fit_all(*state.found.around, state.found.final.model, state.found.final.objective,
                       alike, screening, {}, judged.fitted()[*which].fit.objective));
    which = judged.best(false, true);
    const std::size_t best = judged.fitted()[which.value_or(0)].candidate;
    state.say(fmt::format("step {}: {} stood for {} more, the best is {}", step + 1,
                          state.candidate(stood).title(), alike.size(),
                          which ? state.candidate(best).title() : "none"));
  }
  return which;
}

/// First those inside their bounds that no residual contradicts; then two together, since one of
/// two missing effects may look contradicted; then what is contradicted, or ends at a bound.
Forward accept_first(SearchState& state, int step, std::vector<Alternative> fitted,
                     const Screening& screening, double least_energy) {
  Judged judged(state, step, std::move(fitted));
  std::optional<std::size_t> which = best_of_its_kind(state, step, screening, least_energy, judged);
  if (!which && accept_pair(state, step, screening, judged.fitted(), least_energy))
    return Forward::found;
  if (!which) which = judged.best(false, false);
  const bool inside = which.has_value();
  if (!which) which = judged.best(true, true);
  if (!which) return Forward::none;
  say_judged(state, step, judged.fitted()[*which], !inside, "");
  accept(state, judged.take(), *which, screening);
  return inside ? Forward::found : Forward::ended;
}

}  // namespace

Forward forward(SearchState& state, int step) {
  Selection& found = state.found;
  Screening screening = step == 0
                            ? found.first
                            : screen(*found.around, found.final.model, found.final.r, state.asked(),
                                     Random(state.options.seed, 10 + step), &found.first,
                                     found.final.J.leftCols(found.final.parameters));
  if (step > 0) state.calibrate(screening);
  const double least =
      std::max(state.practical(), state.decisions().minimum_share * found.final_heldout.sum());
  const std::vector<std::size_t> which =
      rivals(state.problem->settings, state.library, screening, least, found.accepted.size());
  if (which.empty()) {
    state.say(fmt::format(
        "step {}: no candidate stands out (strongest score {:.2f}, critical {:.2f})", step + 1,
        screening.probes.empty() ? 0.0 : screening.best(screening.ranking().front())->score,
        screening.critical));
    return accept_pair(state, step, screening, {}, least) ? Forward::found : Forward::none;
  }
  return accept_first(
      state, step,
      fit_all(*found.around, found.final.model, found.final.objective, which, screening), screening,
      least);
}

}  // namespace sanso::diagnose
