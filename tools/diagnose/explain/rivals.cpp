// Full fits of candidates for one place of the model, and their order:
//
//   tried     p < family_wise and linear_reach z^2 > least energy, the best of every cluster; then
//             what the best of these stood for
//   behind    what the best gains over it on held-out groups (HeldoutGain)
//   best      fewest parameters among those not beaten: gain <= standard errors + unit, or energy
//             removed <= what matters
#include "tools/diagnose/explain/rivals.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/effects/dry_friction.h"
#include "tools/diagnose/fit/normal_equations.h"
#include "tools/diagnose/fit/start.h"
#include "tools/diagnose/stats/significance.h"

namespace sanso::diagnose {
namespace {

/// Of every cluster of `significant` (strongest first) the strongest.
std::vector<std::size_t> cluster_leaders(const Screening& screening,
                                         const std::vector<std::size_t>& significant,
                                         double same_signature) {
  std::vector<std::size_t> leaders;
  for (const std::size_t c : significant) {
    const bool new_cluster = std::none_of(leaders.begin(), leaders.end(), [&](std::size_t other) {
      return screening.similarity(c, other) > same_signature;
    });
    if (new_cluster) leaders.push_back(c);
  }
  return leaders;
}

/// Candidates that promise enough and beyond chance, strongest first.
std::vector<std::size_t> worth_a_fit(const Settings& settings, const Library& library,
                                     const Screening& screening, double least_energy) {
  std::vector<std::size_t> out;
  for (const std::size_t c : screening.ranking()) {
    if (library[c].random) continue;  // judged by scatter
    const ProbeScore& best = *screening.best(c);
    // what a fit can remove is the squared score, as far as the model is linear
    const bool worth = settings.fitting.linear_reach * best.together * best.together > least_energy;
    if (best.p_family < settings.decisions.family_wise && worth) out.push_back(c);
  }
  return out;
}

/// The same effect at some of the same joints: what one of them is about to be accepted for, the
/// other is asked then (stood_for).
bool one_place(const Candidate& a, const Candidate& b) {
  const auto there = [&](std::size_t j) {
    return std::find(b.joints.begin(), b.joints.end(), j) != b.joints.end();
  };
  return a.effect == b.effect && std::any_of(a.joints.begin(), a.joints.end(), there);
}

const Alternative* find(const std::vector<Alternative>& all, std::size_t c) {
  const auto it =
      std::find_if(all.begin(), all.end(), [c](const Alternative& a) { return a.candidate == c; });
  return it == all.end() ? nullptr : &*it;
}

/// What happens at one instant shows in few shots.
bool is_event(const Candidate& c) {
  return std::any_of(c.parameters.begin(), c.parameters.end(),
                     [](const CandidateParameter& p) { return p.role == Role::event; });
}

/// Of what is far behind: too good for it by what its fit has learned, and far behind even so.
Eigen::VectorXd seen_energy(const Surroundings& around, const FitResult& fit) {
  return around.bounded(around.starts.energy_by_shot(fit.r));
}

/// An earlier fit that was far behind, judged again without fitting it.
Alternative as_it_was(const Surroundings& around, Alternative a) {
  a.fit.r = prediction_error(around.problem, *around.library, a.fit.model);
  a.heldout = seen_energy(around, a.fit);
  a.fit.objective = a.heldout.sum();
  return a;
}

/// A tolerance that went to its bound on the way may hold a fit where it is: once more from the
/// same effects with the tolerances at their null, and what is better.
FitResult freed(const Surroundings& around, FitResult found) {
  const auto nuisances = found.fixed.begin() + found.parameters;
  if (std::find(nuisances, found.fixed.end(), 1) == found.fixed.end()) return found;
  const FittingSettings& fitting = around.settings().fitting;
  FitResult again = rough_fit(around, Model{found.model.effects, {}}, fitting.first_iterations);
  if (again.objective >= found.objective) return found;
  return resume(around, std::move(again), fitting.iterations - fitting.first_iterations);
}

/// Numbers that the alternative's fit really chose: what no row of the data shows (a centre of mass
/// along its joint's axis) has no covariance but the prior's whisper.
int numbers_chosen(const DecisionSettings& settings, const Library& library, const Alternative& a) {
  const Candidate& c = library[a.candidate];
  int out = free_parameters(c);
  if (a.fit.covariance.rows() == 0) return out;
  Eigen::Index at = a.fit.parameters - static_cast<Eigen::Index>(c.parameters.size());
  for (const CandidateParameter& p : c.parameters) {
    if (!p.structural && a.fit.covariance(at, at) * kWhisper > settings.unseen) --out;
    ++at;
  }
  return out;
}

/// Parameters of effect `i` of a fit: f(parameter, value, its place among all effects' parameters)
/// until it returns true.
template <class F>
bool any_parameter(const Library& library, const FitResult& fit, std::size_t i, const F& f) {
  std::size_t first = 0;
  for (std::size_t k = 0; k < i; ++k) first += library[fit.model.effects[k]].parameters.size();
  const Chosen& effect = fit.model.effects[i];
  const std::vector<CandidateParameter>& parameters = library[effect].parameters;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    if (parameters[k].structural) continue;
    if (f(parameters[k], effect.theta[k], first + k)) return true;
  }
  return false;
}

/// Of the joint's positions in all recordings [rad; m].
double range_of(const Comparison& comparison, std::size_t joint) {
  double low = INFINITY, high = -low;
  for (const Source& s : comparison.sources) {
    const auto [least, most] =
        std::minmax_element(s.motion.q[joint].begin(), s.motion.q[joint].end());
    low = std::min(low, *least), high = std::max(high, *most);
  }
  return high - low;
}

}  // namespace

bool says_no_more(const Comparison& comparison, const Library& library, const Model& model,
                  std::size_t candidate) {
  const Effect* effect = find_effect(library[candidate].effect);
  if (effect == nullptr || !effect->builds_up || !model.has(candidate)) return false;
  SimParams params = comparison.sources.front().nominal;
  library.apply(model, params);
  const std::vector<std::size_t>& joints = library[candidate].joints;
  return std::all_of(joints.begin(), joints.end(), [&](std::size_t j) {
    return bend_of_dry_friction(params.joints[j]) <= comparison.settings.tolerances.bend;
  });
}

bool says_no_more(const Comparison& comparison, const Library& library, const Alternative& a) {
  return says_no_more(comparison, library, a.fit.model, a.candidate);
}

bool unrepeated(const Comparison& comparison, const Candidate& c,
                const std::vector<double>& theta) {
  const double phase = 2.0 * std::numbers::pi * comparison.settings.library.periods;
  for (std::size_t i = 0; i < c.parameters.size(); ++i) {
    if (c.parameters[i].role != Role::order) continue;
    for (const std::size_t j : c.joints) {
      if (theta[i] * range_of(comparison, j) < phase) return true;
    }
  }
  return false;
}

bool contains(const Candidate& larger, const Candidate& simple) {
  return larger.where == simple.where && std::find(larger.contains.begin(), larger.contains.end(),
                                                   simple.effect) != larger.contains.end();
}

bool says_as_much(const Comparison& comparison, const Library& library, std::size_t simple,
                  const Alternative& larger) {
  return contains(library[larger.candidate], library[simple]) &&
         says_no_more(comparison, library, larger);
}

int free_parameters(const Candidate& c) {
  return static_cast<int>(
      std::count_if(c.parameters.begin(), c.parameters.end(), [](const CandidateParameter& p) {
        // orders, places and instants are searched: as good as fitted
        return !p.structural || p.role != Role::size;
      }));
}

double errors_ahead(const DecisionSettings& settings, std::size_t rivals) {
  if (rivals < 2) return settings.standard_errors;
  return normal_score(normal_tail(settings.standard_errors) / static_cast<double>(rivals));
}

bool beaten(const DecisionSettings& settings, const HeldoutGain& behind, double practical,
            std::size_t rivals) {
  return behind.certainty() > errors_ahead(settings, rivals) && behind.removed() > practical;
}

double practical_energy(const Comparison& comparison) {
  const double size = comparison.settings.decisions.practical_size;
  return std::max(kNoiseUnit, size * size * rows_of_a_joint(comparison));
}

std::size_t most_rivals(const DecisionSettings& settings, std::size_t names) {
  const int beside = settings.rivals_beside / static_cast<int>(std::max<std::size_t>(names, 1));
  return static_cast<std::size_t>(std::clamp(beside, 1, settings.rivals));
}

std::vector<std::size_t> rivals(const Settings& settings, const Library& library,
                                const Screening& screening, double least_energy,
                                std::size_t names) {
  const DecisionSettings& decisions = settings.decisions;
  const std::vector<std::size_t> significant =
      worth_a_fit(settings, library, screening, least_energy);
  std::vector<std::size_t> chosen;
  const std::vector<std::size_t> leaders =
      cluster_leaders(screening, significant, decisions.same_signature);
  const std::size_t most = most_rivals(decisions, names + 1);
  const auto add = [&](std::size_t c) {
    if (chosen.size() < most && std::find(chosen.begin(), chosen.end(), c) == chosen.end())
      chosen.push_back(c);
  };
  for (const std::size_t leader : leaders) {
    std::size_t simplest = leader;
    for (const std::size_t c : significant) {
      const bool member = screening.similarity(c, leader) > decisions.same_signature;
      const bool nearly = screening.best(c)->together >
                          decisions.nearly_strongest * screening.best(leader)->together;
      if (member && nearly && free_parameters(library[c]) < free_parameters(library[simplest]))
        simplest = c;
    }
    const bool asked = std::any_of(chosen.begin(), chosen.end(), [&](std::size_t c) {
      return one_place(library[c], library[simplest]);
    });
    if (!asked) add(simplest);
    if (leader == leaders.front()) add(leader);
  }
  for (const std::size_t leader : leaders) add(leader);
  for (const std::size_t c : significant) add(c);
  return chosen;
}

std::vector<std::size_t> stood_for(const Settings& settings, const Library& library,
                                   const Screening& screening, double least_energy,
                                   std::size_t candidate, const std::vector<Alternative>& fitted,
                                   std::size_t names) {
  const std::size_t most = most_rivals(settings.decisions, names + 1);
  std::vector<std::size_t> out;
  for (const std::size_t c : worth_a_fit(settings, library, screening, least_energy)) {
    const bool alike = library[c].effect == library[candidate].effect ||
                       screening.similarity(c, candidate) > settings.decisions.same_signature;
    if (alike && c != candidate && find(fitted, c) == nullptr && out.size() < most)
      out.push_back(c);
  }
  return out;
}

std::vector<std::size_t> replacements(const DecisionSettings& settings, const Library& library,
                                      const Screening& first, const Model& model,
                                      std::size_t accepted,
                                      const std::vector<Alternative>& fitted) {
  std::vector<std::pair<double, std::size_t>> order;
  const Candidate& own = library[accepted];
  for (std::size_t c = 0; c < library.candidates.size(); ++c) {
    const Candidate& other = library[c];
    if (model.has(c) || other.random) continue;
    const double similarity = first.similarity(accepted, c);
    const bool same_place =
        other.joints == own.joints || other.joints.empty() || own.joints.empty();
    const bool known = same_place && std::find(own.confounders.begin(), own.confounders.end(),
                                               other.effect) != own.confounders.end();
    if (similarity > settings.same_signature || known || find(fitted, c) != nullptr)
      order.emplace_back(similarity + (known ? settings.known_first : 0.0), c);
  }
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  const std::size_t most = most_rivals(settings, model.effects.size());
  std::vector<std::size_t> out;
  for (const auto& [score, c] : order) {
    if (out.size() < most) out.push_back(c);
  }
  return out;
}

std::vector<Alternative> fit_all(const Surroundings& around, const Model& base,
                                 double base_objective, const std::vector<std::size_t>& which,
                                 const Screening& screening, const std::vector<Alternative>& known,
                                 double beside) {
  std::vector<Alternative> out(which.size());
  const Surroundings some = some_shots(around, base);
  parallel_for(which.size(), [&](std::size_t i) {
    Alternative& a = out[i];
    a.candidate = which[i];
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
      const Surroundings& where = is_event((*around.library)[a.candidate]) ? around : some;
      start = best_start(where, base, a.candidate, screening.best(a.candidate));
    }
    a.fit = rough_fit(around, start, around.settings().fitting.first_iterations);
  });
  double best = beside;
  for (const Alternative& a : out) best = std::min(best, a.fit.objective);
  const double near =
      best + around.settings().fitting.polish_share * std::max(0.0, base_objective - best);
  parallel_for(which.size(), [&](std::size_t i) {
    Alternative& a = out[i];
    const bool as_before = a.far_behind;
    a.far_behind = a.fit.objective > near;
    if (as_before && a.far_behind) return;
    if (a.far_behind) {
      a.heldout = seen_energy(around, a.fit);
      return;
    }
    const FittingSettings& fitting = around.settings().fitting;
    // what was far behind where channels and shots were weighed otherwise
    if (as_before) a.fit = rough_fit(around, a.fit.model, fitting.first_iterations);
    const int left = a.fit.converged ? 0 : fitting.iterations - fitting.first_iterations;
    a.fit = freed(around, resume(around, std::move(a.fit), left));
    a.heldout = heldout_energy(around, a.fit);
  });
  return out;
}

void rank(const Library& library, const Problem& problem, std::vector<Alternative>& all) {
  if (all.empty()) return;
  const DecisionSettings& decisions = problem->settings.decisions;
  double unit = INFINITY;
  for (const Alternative& a : all) unit = std::min(unit, typical_energy(a.heldout));
  std::stable_sort(all.begin(), all.end(), [unit](const Alternative& a, const Alternative& b) {
    if (a.far_behind != b.far_behind) return b.far_behind;
    return bounded_energy(a.heldout, unit) < bounded_energy(b.heldout, unit);
  });
  const Eigen::VectorXd best = all.front().heldout;
  for (Alternative& a : all) a.behind = compare(*problem, a.heldout, best);
  std::size_t pick = 0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    // a name with more parameters has to be better beyond chance, by something that matters
    const bool close =
        !all[i].far_behind && (!beaten(decisions, all[i].behind, practical_energy(*problem)) ||
                               says_as_much(*problem, library, all[i].candidate, all.front()));
    const bool simpler = numbers_chosen(decisions, library, all[i]) <
                             numbers_chosen(decisions, library, all[pick]) ||
                         says_as_much(*problem, library, all[i].candidate, all[pick]);
    if (close && simpler) pick = i;
  }
  std::rotate(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(pick),
              all.begin() + static_cast<std::ptrdiff_t>(pick) + 1);
}

bool leaves_null(const DecisionSettings& settings, const Library& library, const FitResult& fit,
                 std::size_t i) {
  const std::vector<CandidateParameter>& all = library[fit.model.effects[i]].parameters;
  if (std::all_of(all.begin(), all.end(), [](const CandidateParameter& p) { return p.structural; }))
    return true;
  const std::vector<double> sigma = parameter_sigmas(fit, library);
  return any_parameter(
      library, fit, i, [&](const CandidateParameter& p, double value, std::size_t place) {
        const double width = fit.fixed[place] != 0 ? 0.0 : settings.standard_errors * sigma[place];
        return std::abs(value - p.null) > width;
      });
}

bool at_bound(const Library& library, const FitResult& fit, std::size_t i) {
  return any_parameter(library, fit, i,
                       [&](const CandidateParameter& p, double value, std::size_t place) {
                         return fit.fixed[place] != 0 && !at_null(p, value);
                       });
}

bool leaves_null(const DecisionSettings& settings, const Library& library, const Alternative& a) {
  return leaves_null(settings, library, a.fit, a.fit.model.effects.size() - 1);
}

bool at_bound(const Library& library, const Alternative& a) {
  return at_bound(library, a.fit, a.fit.model.effects.size() - 1);
}

}  // namespace sanso::diagnose
