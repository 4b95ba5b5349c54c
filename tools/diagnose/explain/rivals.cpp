// Full fits of candidates for one place of the model, and their order:
//
//   tried     p < family_wise and linear_reach z^2 > least energy, the best of every cluster
//   behind    E(candidate) - E(best) on held-out groups, with its paired standard error
//   best      fewest parameters among behind <= max(standard error + unit, what matters)
#include "tools/diagnose/explain/rivals.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/fit/start.h"

namespace sanso::diagnose {
namespace {

const Candidate& candidate(const Library& library, int i) {
  return library.candidates[static_cast<std::size_t>(i)];
}

int free_parameters(const Candidate& c) {
  return static_cast<int>(std::count_if(c.parameters.begin(), c.parameters.end(),
                                        [](const CandidateParameter& p) { return !p.structural; }));
}

/// Of every cluster of `significant` (strongest first) the strongest.
std::vector<int> cluster_leaders(const Screening& screening, const std::vector<int>& significant,
                                 double same_signature) {
  std::vector<int> leaders;
  for (const int c : significant) {
    const bool new_cluster = std::none_of(leaders.begin(), leaders.end(), [&](int other) {
      return screening.similarity(c, other) > same_signature;
    });
    if (new_cluster) leaders.push_back(c);
  }
  return leaders;
}

const Alternative* find(const std::vector<Alternative>& all, int c) {
  const auto it =
      std::find_if(all.begin(), all.end(), [c](const Alternative& a) { return a.candidate == c; });
  return it == all.end() ? nullptr : &*it;
}

/// An earlier fit that was far behind, judged again without fitting it.
Alternative as_it_was(const Surroundings& around, Alternative a) {
  a.fit.r = prediction_error(*around.problem, *around.library, a.fit.model);
  // too good for it by what its fit has learned
  a.heldout = around.bounded(around.starts.energy_by_shot(a.fit.r));
  a.fit.objective = a.heldout.sum();
  return a;
}

/// Parameters of the last effect of a fit: f(parameter, value, sigma, held at a bound) until it
/// returns true.
template <class F>
bool any_parameter(const Library& library, const Alternative& a, const F& f) {
  const std::vector<double> sigma = parameter_sigmas(a.fit, library);
  const std::vector<CandidateParameter>& parameters = candidate(library, a.candidate).parameters;
  const std::size_t first = sigma.size() - parameters.size();
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (parameters[i].structural) continue;
    if (f(parameters[i], a.fit.model.effects.back().theta[i], sigma[first + i],
          a.fit.fixed[first + i] != 0))
      return true;
  }
  return false;
}

}  // namespace

double practical_energy(const Problem& problem) {
  const double size = problem.settings.decisions.practical_size;
  return std::max(kNoiseUnit, size * size * rows_of_a_joint(problem));
}

std::vector<int> rivals(const Settings& settings, const Library& library,
                        const Screening& screening, double least_energy) {
  const DecisionSettings& decisions = settings.decisions;
  std::vector<int> significant, chosen;
  for (const int c : screening.ranking()) {
    if (candidate(library, c).random) continue;  // judged by scatter
    const ProbeScore& best = *screening.best(c);
    // what a fit can remove is the squared score, as far as the model is linear
    const bool worth = settings.fitting.linear_reach * best.score * best.score > least_energy;
    if (best.p_family < decisions.family_wise && worth) significant.push_back(c);
  }
  const std::vector<int> leaders =
      cluster_leaders(screening, significant, decisions.same_signature);
  const auto add = [&](int c) {
    if (static_cast<int>(chosen.size()) < decisions.rivals &&
        std::find(chosen.begin(), chosen.end(), c) == chosen.end())
      chosen.push_back(c);
  };
  for (const int leader : leaders) {
    int simplest = leader;
    for (const int c : significant) {
      const bool member = screening.similarity(c, leader) > decisions.same_signature;
      const bool nearly = screening.best(c)->score > 0.8 * screening.best(leader)->score;
      if (member && nearly &&
          free_parameters(candidate(library, c)) < free_parameters(candidate(library, simplest)))
        simplest = c;
    }
    add(simplest);
    if (leader == leaders.front()) add(leader);
  }
  for (const int leader : leaders) add(leader);
  for (const int c : significant) add(c);
  return chosen;
}

std::vector<int> replacements(const DecisionSettings& settings, const Library& library,
                              const Screening& first, const Model& model, int accepted,
                              const std::vector<Alternative>& fitted) {
  std::vector<std::pair<double, int>> order;
  const Candidate& own = candidate(library, accepted);
  for (std::size_t i = 0; i < library.candidates.size(); ++i) {
    const int c = static_cast<int>(i);
    const Candidate& other = candidate(library, c);
    if (model.has(c) || other.random) continue;
    const double similarity = first.similarity(accepted, c);
    const bool same_place =
        other.joints == own.joints || other.joints.empty() || own.joints.empty();
    const bool known = same_place && std::find(own.confounders.begin(), own.confounders.end(),
                                               other.effect) != own.confounders.end();
    if (similarity > settings.same_signature || known || find(fitted, c) != nullptr)
      order.emplace_back(similarity + (known ? 0.5 : 0.0), c);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<int> out;
  for (const auto& [score, c] : order) {
    if (static_cast<int>(out.size()) < settings.rivals) out.push_back(c);
  }
  return out;
}

std::vector<Alternative> fit_all(const Surroundings& around, const Model& base,
                                 double base_objective, const std::vector<int>& which,
                                 const Screening& screening,
                                 const std::vector<Alternative>& known) {
  std::vector<Alternative> out(which.size());
  parallel_for(static_cast<int>(which.size()), [&](int i) {
    Alternative& a = out[static_cast<std::size_t>(i)];
    a.candidate = which[static_cast<std::size_t>(i)];
    const Alternative* before = find(known, a.candidate);
    const bool same_base =
        base.effects.empty() && before != nullptr && before->fit.model.effects.size() == 1;
    if (same_base && before->far_behind) {
      a = as_it_was(around, *before);
      return;
    }
    Model start{base.effects, {}};
    if (before != nullptr) {
      start.effects.push_back(before->fit.model.effects.back());
    } else {
      start = best_start(around, base, a.candidate, screening.best(a.candidate));
    }
    a.fit = fit(around, start, around.settings().fitting.first_iterations);
  });
  double best = INFINITY;
  for (const Alternative& a : out) best = std::min(best, a.fit.objective);
  const double near =
      best + around.settings().fitting.polish_share * std::max(0.0, base_objective - best);
  parallel_for(static_cast<int>(which.size()), [&](int i) {
    Alternative& a = out[static_cast<std::size_t>(i)];
    if (a.far_behind) return;
    a.far_behind = a.fit.objective > near;
    if (!a.fit.converged && !a.far_behind)
      a.fit =
          resume(around, std::move(a.fit),
                 around.settings().fitting.iterations - around.settings().fitting.first_iterations);
    a.heldout = heldout_energy(around, a.fit);
  });
  return out;
}

void rank(const Library& library, const Problem& problem, std::vector<Alternative>& all) {
  if (all.empty()) return;
  std::stable_sort(all.begin(), all.end(), [](const Alternative& a, const Alternative& b) {
    return a.heldout.sum() < b.heldout.sum();
  });
  const Eigen::VectorXd best = all.front().heldout;
  for (Alternative& a : all) {
    const HeldoutGain g = compare(problem.settings.decisions, a.heldout, best);
    a.behind = g.total;
    a.behind_se = g.standard_error;
  }
  std::size_t pick = 0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    // a name with more parameters has to be better by something that matters
    const bool close =
        all[i].behind <= std::max(all[i].behind_se + kNoiseUnit, practical_energy(problem));
    if (close && free_parameters(candidate(library, all[i].candidate)) <
                     free_parameters(candidate(library, all[pick].candidate)))
      pick = i;
  }
  std::rotate(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(pick),
              all.begin() + static_cast<std::ptrdiff_t>(pick) + 1);
}

bool leaves_null(const DecisionSettings& settings, const Library& library, const Alternative& a) {
  const std::vector<CandidateParameter>& all = candidate(library, a.candidate).parameters;
  if (std::all_of(all.begin(), all.end(), [](const CandidateParameter& p) { return p.structural; }))
    return true;
  const double width = settings.standard_errors;
  return any_parameter(
      library, a, [width](const CandidateParameter& p, double value, double sigma, bool fixed) {
        return std::abs(value - p.null) > (fixed ? 0.0 : width * sigma);
      });
}

bool at_bound(const Library& library, const Alternative& a) {
  return any_parameter(library, a,
                       [](const CandidateParameter& p, double value, double, bool fixed) {
                         return fixed && !at_null(p, value);
                       });
}

}  // namespace sanso::diagnose
