// Every accepted effect is tried against what else could stand in its place, now that the
// others are known: the first screening saw none of them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/explain/steps.h"
#include "tools/diagnose/fit/imitate.h"

namespace sanso::diagnose {
namespace {

/// It stands for want of a name: whatever predicts as well with fewer numbers may be one (rank).
bool not_seen_to_repeat(const SearchState& state, const Alternative& a) {
  const std::vector<Chosen>& effects = a.fit.model.effects;
  return std::any_of(effects.begin(), effects.end(), [&](const Chosen& e) {
    return e.candidate == a.candidate && unrepeated(*state.problem, state.library[e], e.theta);
  });
}

/// The best of those tried is another effect, and no gate speaks against it. It predicts better,
/// says as much with less, or as much as a ripple that nobody saw repeat.
bool better(const SearchState& state, const std::vector<Alternative>& tried,
            const Alternative& self) {
  const Alternative& best = tried.front();
  return best.candidate != self.candidate && !best.far_behind && !at_bound(state.library, best) &&
         leaves_null(state.decisions(), state.library, best) &&
         (says_as_much(*state.problem, state.library, best.candidate, self) ||
          not_seen_to_repeat(state, self) ||
          (compare(*state.problem, self.heldout, best.heldout).bounded.total > kNoiseUnit &&
           holds_on_conditions(state, best)));
}

/// A rival that looks like the i-th effect and was fitted worse may only have ended in another
/// hollow: where it can say the same as the effect, it is fitted to the data from there.
void fit_from_its_prediction(const SearchState& state, std::size_t i, Alternative& rival) {
  const Selection& found = state.found;
  const Surroundings& around = *found.around;
  const Candidate& own = state.accepted(i);
  const bool alike = documented_twin(state.candidate(rival.candidate).effect, own.effect) ||
                     found.first.similarity(rival.candidate, found.accepted[i].candidate) >
                         state.decisions().same_signature;
  if (!alike || rival.fit.objective < found.final.objective + kNoiseUnit) return;
  const Imitation same = imitate(around, found.final, i, rival.fit.model.effects.back());
  if (same.distance > state.practical()) return;
  FitResult fitted = rough_fit(around, same.model, around.settings().fitting.iterations);
  if (fitted.objective >= rival.fit.objective) return;
  rival.fit = resume(around, std::move(fitted), 0);
  rival.heldout = heldout_energy(around, rival.fit);
  rival.far_behind = false;
}

/// Predicts what the model predicts, within what matters: no data tell them apart, and how fits
/// without a group happen to differ does not either.
bool says_the_same(const SearchState& state, const Alternative& a) {
  const Surroundings& around = *state.found.around;
  const Eigen::VectorXd apart =
      prediction_error(around.problem, *around.library, a.fit.model) - state.found.final.r;
  return around.bounded(around.starts.energy_by_shot(apart)).sum() <= state.practical();
}

/// The others that were tried, with how far they are behind what is at place i now.
std::vector<Alternative> behind_it(const SearchState& state, std::size_t i,
                                   std::vector<Alternative> tried) {
  const Selection& found = state.found;
  const Accepted& entry = found.accepted[i];
  std::vector<Alternative> others;
  for (Alternative& a : tried) {
    if (a.candidate == entry.candidate) continue;
    if (!a.far_behind && says_the_same(state, a))
      a.behind.energy.standard_error = a.behind.bounded.standard_error = INFINITY;
    else
      a.behind = state.gain_of(found.final.model.effects[i], a.heldout, found.final_heldout);
    a.similarity = found.first.similarity(a.candidate, entry.candidate);
    others.push_back(std::move(a));
  }
  std::stable_sort(others.begin(), others.end(), [](const Alternative& a, const Alternative& b) {
    return a.behind.bounded.total < b.behind.bounded.total;
  });
  for (Alternative& a : others) a.fit.J.resize(0, 0);
  return others;
}

}  // namespace

void take_place(SearchState& state, std::size_t i, const Alternative& other) {
  Accepted& entry = state.found.accepted[i];
  state.say(fmt::format("swapped {} for {}", state.candidate(entry.candidate).title(),
                        state.candidate(other.candidate).title()));
  const Chosen chosen = other.fit.model.effects.back();
  entry.candidate = chosen.candidate;
  // the new effect stands last: put it in its predecessor's place
  Model model = other.fit.model;
  model.effects.pop_back();
  model.effects.insert(model.effects.begin() + static_cast<std::ptrdiff_t>(i), chosen);
  state.found.final.model = model;
  state.relinearise();
}

bool swap_for_better(SearchState& state) {
  Selection& found = state.found;
  bool swapped = false;
  for (std::size_t i = 0; i < found.accepted.size(); ++i) {
    Accepted& entry = found.accepted[i];
    if (state.accepted(i).random) continue;  // its rivals would be judged by a mean that it has not
    Model base = found.final.model;
    base.effects.erase(base.effects.begin() + static_cast<std::ptrdiff_t>(i));
    const std::vector<std::size_t> which =
        replacements(state.decisions(), state.library, found.first, found.final.model,
                     entry.candidate, entry.alternatives);
    // far behind is told by what the effect itself removes: by what the best of the others gains
    // over it, all but that one were
    std::vector<Alternative> tried =
        fit_all(*found.around, base, state.rough_without(i).objective, which, found.first,
                entry.alternatives, found.final.objective);
    parallel_for(tried.size(), [&](std::size_t k) { fit_from_its_prediction(state, i, tried[k]); });
    const Alternative self{entry.candidate, found.final, found.final_heldout};
    tried.push_back(self);
    rank(state.library, state.problem, tried);
    // self is among them
    const auto best = std::find_if(tried.begin(), tried.end(), [&](const Alternative& a) {
      return a.candidate == self.candidate || !only_how_it_builds_up(state, a);
    });
    std::rotate(tried.begin(), best, best + 1);
    if (better(state, tried, self)) {
      take_place(state, i, tried.front());
      swapped = true;
    }
    entry.alternatives = behind_it(state, i, std::move(tried));
  }
  return swapped;
}

/// Whether a rival of the i-th name was judged beside the names that stand beside it now.
bool beside_the_same(const Model& final, std::size_t i, const Model& rival) {
  if (rival.effects.size() != final.effects.size()) return false;
  for (std::size_t k = 0, other = 0; k < final.effects.size(); ++k) {
    if (k == i) continue;
    if (rival.effects[other++].candidate != final.effects[k].candidate) return false;
  }
  return true;
}

/// The model with the i-th name's place taken by a rival, which stands last.
Model in_its_place(Model model, std::size_t i, const Chosen& rival) {
  model.effects.erase(model.effects.begin() + static_cast<std::ptrdiff_t>(i));
  model.effects.push_back(rival);
  return model;
}

void follow_level_rivals(SearchState& state, std::size_t i) {
  const Selection& found = state.found;
  const Surroundings& around = *found.around;
  const Eigen::VectorXd seen = around.bounded(around.starts.energy_by_shot(found.final.r));
  std::vector<Alternative>& others = state.found.accepted[i].alternatives;
  parallel_for(others.size(), [&](std::size_t k) {
    Alternative& rival = others[k];
    const bool up_to_date = beside_the_same(found.final.model, i, rival.fit.model);
    if (up_to_date && !rival.far_behind) return;
    if (found.final.model.has(rival.candidate)) return;
    const FittingSettings& fitting = around.settings().fitting;
    if (!up_to_date)  // a few steps tell whether it is far behind beside these names
      rival.fit =
          rough_fit(around, in_its_place(found.final.model, i, rival.fit.model.effects.back()),
                    fitting.first_iterations);
    rival.heldout = around.bounded(around.starts.energy_by_shot(
        prediction_error(around.problem, *around.library, rival.fit.model)));
    // what was fitted to its end is not left for what a few steps say of it
    rival.far_behind =
        rival.far_behind &&
        beaten(state.decisions(), compare(*state.problem, rival.heldout, seen), state.practical());
    if (!up_to_date)
      rival.behind =
          state.gain_of(found.final.model.effects[i], rival.heldout, found.final_heldout);
    if (rival.far_behind) return;
    rival.fit = resume(around, rough_fit(around, rival.fit.model, fitting.iterations), 0);
    rival.heldout = heldout_energy(around, rival.fit);
    rival.behind = state.gain_of(found.final.model.effects[i], rival.heldout, found.final_heldout);
    rival.fit.J.resize(0, 0);
  });
}

}  // namespace sanso::diagnose
