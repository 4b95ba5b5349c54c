// One more name: screen, fit the best rivals, accept the first that passes every gate.
//
//   screening     z = s'Mr / sqrt(s'Ms) of every open candidate; family-wise p over all of them
//   rivals        cluster representatives whose p and promised gain count, fitted fully
//   rank          by held-out energy, one standard error's grace for fewer parameters
//   gates         refused_by: gain, null, conditions, its instant, its residuals
#include <fmt/format.h>

#include <algorithm>
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
      "{:.1f}){}{}",
      step + 1, state.candidate(a.candidate).title(), 100 * gain.removed() / state.whole(),
      100 * gain.energy.lower / state.whole(), 100 * gain.bounded.total / gain.whole,
      100 * gain.bounded.lower / gain.whole, bounds_allowed ? ", ends at a bound" : "",
      refused.empty() ? ", accepted" : ", refused: " + refused));
}

/// What stands against a name: its gates, then the residual that it should have changed.
struct Objections {
  std::string gate, residual;
};

Objections objections_to(const SearchState& state, const Alternative& a) {
  Objections out;
  out.gate = refused_by(state, a);
  if (out.gate.empty()) out.residual = state.residual_against(state.found.final, a.fit);
  return out;
}

/// First those inside their bounds that no residual contradicts; one of two missing effects may
/// look contradicted.
bool accept_first(SearchState& state, int step, std::vector<Alternative> fitted,
                  const Screening& screening) {
  std::vector<std::optional<Objections>> judged(fitted.size());
  for (const auto& [bounds_allowed, refutable] :
       {std::pair{false, true}, {false, false}, {true, true}}) {
    for (std::size_t i = 0; i < fitted.size(); ++i) {
      if (at_bound(state.library, fitted[i]) != bounds_allowed) continue;
      const bool first_time = !judged[i];
      if (first_time) judged[i] = objections_to(state, fitted[i]);
      const std::string& refused =
          judged[i]->gate.empty() && refutable ? judged[i]->residual : judged[i]->gate;
      if (first_time || refused.empty())
        say_judged(state, step, fitted[i], bounds_allowed, refused);
      if (!refused.empty()) continue;
      accept(state, std::move(fitted), i, screening);
      return true;
    }
  }
  return false;
}

}  // namespace

bool forward(SearchState& state, int step) {
  Selection& found = state.found;
  Screening screening = step == 0
                            ? found.first
                            : screen(*found.around, found.final.model, found.final.r, state.open(),
                                     Random(state.options.seed, 10 + step), &found.first,
                                     found.final.J.leftCols(found.final.parameters));
  if (step > 0) state.calibrate(screening);
  const std::vector<std::size_t> which = rivals(
      state.problem->settings, state.library, screening,
      std::max(state.practical(), state.decisions().minimum_share * found.final_heldout.sum()));
  if (which.empty()) {
    state.say(fmt::format(
        "step {}: no candidate stands out (strongest score {:.2f}, critical {:.2f})", step + 1,
        screening.probes.empty() ? 0.0 : screening.best(screening.ranking().front())->score,
        screening.critical));
    return false;
  }
  std::vector<Alternative> fitted =
      fit_all(*found.around, found.final.model, found.final.objective, which, screening);
  rank(state.library, state.problem, fitted);
  return accept_first(state, step, std::move(fitted), screening);
}

}  // namespace sanso::diagnose
