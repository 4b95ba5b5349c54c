// Where a fit of an effect begins: the probe whose change explains most, for parameters without a
// derivative a search along them.
#include "tools/diagnose/fit/start.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "tools/diagnose/effects/parameter_of.h"
#include "tools/diagnose/fit/quick_fit.h"
#include "tools/diagnose/gate/checks.h"

namespace sanso::diagnose {
namespace {

double error_energy(const Surroundings& around, const Model& model) {
  const Eigen::VectorXd r = prediction_error(around.problem, *around.library, model);
  return around.bounded(around.starts.energy_by_shot(r)).sum();
}

/// Inside the bounds by `share` of the range (rule 2 of the method page: no fit starts at one).
std::vector<double> inside(const Candidate& effect, std::vector<double> theta, double share) {
  for (std::size_t i = 0; i < theta.size(); ++i) {
    const CandidateParameter& p = effect.parameters[i];
    if (p.structural) continue;
    // an effect that is off at infinity has no meaningful width: there half a typical size is the
    // margin
    const double margin = std::min(share * (p.high - p.low), 0.5 * p.typical);
    const double low = p.null == p.low ? p.low + std::min(margin, 0.1 * p.typical) : p.low + margin;
    theta[i] = std::clamp(theta[i], low, p.high - margin);
  }
  return theta;
}

/// The probe at `factor` times its distance from the null, inside the bounds by `share`.
std::vector<double> scaled(const Candidate& effect, const std::vector<double>& probe, double factor,
                           double share) {
  std::vector<double> theta = probe;
  for (std::size_t i = 0; i < theta.size(); ++i) {
    const CandidateParameter& p = effect.parameters[i];
    if (p.structural || p.role == Role::position || probe[i] == p.null) continue;
    // what is off at its null is scaled, not moved away from it
    theta[i] = p.null == kOff ? probe[i] * std::abs(factor) : p.null + factor * (probe[i] - p.null);
  }
  return inside(effect, std::move(theta), share);
}

Model with(const Model& base, std::size_t candidate, std::vector<double> theta) {
  Model out{base.effects, {}};
  out.effects.push_back({candidate, std::move(theta)});
  return out;
}

/// Sizes along the line from the null through the probe: what the matched filter promises, and
/// fractions and multiples of the probe to both sides of it.
Model best_size(const Surroundings& around, const Model& base, std::size_t candidate,
                const std::vector<double>& probe, double amount) {
  const Candidate& effect = (*around.library)[candidate];
  const double share = around.settings().fitting.inside_bound;
  const double farthest = around.settings().fitting.farthest_start;
  std::vector<double> factors{std::clamp(amount, -farthest, farthest)};
  for (const double f : {0.3, 0.6, 1.0, 1.4, 1.8, 2.4, 3.2})
    factors.push_back(std::copysign(f, amount));
  Model best;
  double least = std::numeric_limits<double>::infinity();
  for (const double f : factors) {
    Model trial = with(base, candidate, scaled(effect, probe, f, share));
    const double energy = error_energy(around, trial);
    if (energy < least) least = energy, best = std::move(trial);
  }
  return best;
}

/// One of two forms that an effect has: where an encoder sits, what a filter acts on.
bool is_form(const CandidateParameter& p) {
  return p.structural && p.role == Role::size && p.low == 0.0 && p.high == 1.0 && p.typical == 1.0;
}

/// Which limits a probe switches on, and which form it has. Of a limit that is off no derivative
/// says that it should be on, nor does one lead from form to form.
std::vector<char> choices_of(const Candidate& effect, const std::vector<double>& probe) {
  std::vector<char> out;
  for (std::size_t i = 0; i < probe.size(); ++i) {
    if (effect.parameters[i].null == kOff) out.push_back(is_on(probe[i]) ? 1 : 0);
    if (is_form(effect.parameters[i])) out.push_back(probe[i] >= 0.5 ? 1 : 0);
  }
  return out;
}

/// `strongest`, and one probe of every other choice of limits and form that is probed.
std::vector<std::size_t> one_of_each_choice(const Candidate& effect, std::size_t strongest) {
  std::vector<std::size_t> out{strongest};
  for (std::size_t p = 0; p < effect.probes.size(); ++p) {
    const bool tried = std::any_of(out.begin(), out.end(), [&](std::size_t other) {
      return choices_of(effect, effect.probes[other]) == choices_of(effect, effect.probes[p]);
    });
    if (!tried) out.push_back(p);
  }
  return out;
}

/// Orders around the probed one, up to the next ones that were probed; at most `order_steps`
/// between.
std::vector<double> orders_near(const Candidate& effect, std::size_t index, double order,
                                const FittingSettings& settings) {
  double below = effect.parameters[index].low, above = effect.parameters[index].high;
  for (const std::vector<double>& probe : effect.probes) {
    if (probe[index] < order) below = std::max(below, probe[index]);
    if (probe[index] > order) above = std::min(above, probe[index]);
  }
  above = std::min(above, settings.beyond_orders * order);  // beyond the last probe
  const double unit = effect.parameters[index].typical;
  const double step =
      unit * std::max(1.0, std::ceil((above - below) / (unit * settings.order_steps)));
  std::vector<double> out;
  for (double o = order - step; o > below; o -= step) out.push_back(o);
  for (double o = order + step; o < above; o += step) out.push_back(o);
  return out;
}

/// The one of `values` of this parameter, or the model's own, whose other parameters leave the
/// least after `iterations` Gauss-Newton steps.
Model best_value(const Surroundings& around, const Model& model, std::size_t index,
                 const std::vector<double>& values, int iterations) {
  QuickFit best = quick_fit(around, model, iterations);
  for (const double value : values) {
    Model trial = model;
    trial.effects.back().theta[index] = value;
    QuickFit fitted = quick_fit(around, trial, iterations);
    if (fitted.objective < best.objective) best = std::move(fitted);
  }
  return best.model;
}

/// One step for all orders around the probed one; then the best of them against its neighbours,
/// fitted further.
Model with_best_order(const Surroundings& around, const Model& model, std::size_t index) {
  const Candidate& effect = (*around.library)[model.effects.back().candidate];
  const std::vector<double> near =
      orders_near(effect, index, model.effects.back().theta[index], around.settings().fitting);
  const Model coarse = best_value(around, model, index, near, 1);
  const double order = coarse.effects.back().theta[index], unit = effect.parameters[index].typical;
  return best_value(around, coarse, index, {order - unit, order + unit},
                    around.settings().fitting.first_iterations);
}

/// Where a parameter that says "from here on" may lie: an instant of the recordings, a position of
/// the joint, a delay.
/// No derivative leads there from afar, so the neighbourhood of the probe is halved until it is
/// small. Step 0: no such parameter.
struct Range {
  double low = 0.0, high = 0.0, step = 0.0;
};
Range range_of_place(const Surroundings& around, const Candidate& effect, std::size_t index) {
  const Role role = effect.parameters[index].role;
  if (role == Role::instant) {  // probed at equal steps
    const double longest = longest_recording(*around.problem);
    return {0.0, longest, longest / around.settings().data.instants};
  }
  if (role == Role::delay) {  // from a whole sample off
    const CandidateParameter& p = effect.parameters[index];
    return {p.low, p.high, 2.0 * gate::sampling_interval(around.problem->sources.front().drive.t)};
  }
  // an event's probes lie half a shot apart
  if (role == Role::event)
    return {0.0, longest_recording(*around.problem), 0.5 * around.settings().data.shot_seconds};
  if (role != Role::position) return {};
  Range out{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(), 0.0};
  for (const std::vector<double>& probe : effect.probes) {
    out.low = std::min(out.low, probe[index]);
    out.high = std::max(out.high, probe[index]);
  }
  // a hard stop is met just before the end of what the joint did, which the probes keep away from
  const double margin = around.settings().data.end_margin;
  const double beyond = (out.high - out.low) * margin / (1.0 - 2.0 * margin);
  out.low -= beyond, out.high += beyond;
  return out;
}

/// `keeps`: index of a parameter that loses what this one gains (an event's end stays where it is).
Model halved_to_best_place(const Surroundings& around, const Model& start, std::size_t index,
                           const Range& range, double least_step,
                           std::optional<std::size_t> keeps = {}) {
  QuickFit best = quick_fit(around, start, 2);
  for (double step = 0.5 * range.step; step > least_step; step *= 0.5) {
    const double place = best.model.effects.back().theta[index];
    for (const double next :
         {std::max(range.low, place - step), std::min(range.high, place + step)}) {
      Model trial = best.model;
      std::vector<double>& theta = trial.effects.back().theta;
      theta[index] = next;
      if (keeps) theta[*keeps] -= next - place;
      if (keeps && !(theta[*keeps] > 0.0)) continue;
      QuickFit fitted = quick_fit(around, trial, 2);
      if (fitted.objective < best.objective) best = std::move(fitted);
    }
  }
  return best.model;
}

/// The last effect with its sizes `factor` times as far from their null, inside their bounds.
Model resized(const Surroundings& around, Model model, double factor) {
  Chosen& last = model.effects.back();
  const Candidate& effect = (*around.library)[last.candidate];
  last.theta = scaled(effect, last.theta, factor, around.settings().fitting.inside_bound);
  return model;
}

/// A position is tried on a grid first, since its probes are few: evenly, and closer to either end.
/// What is stiff is met deeper than what is soft, and no derivative leads from one to the other
/// past the shots that hit it; so every stiffness looks for its own place.
Model with_best_position(const Surroundings& around, const Model& start, std::size_t index,
                         Range range) {
  const FittingSettings& settings = around.settings().fitting;
  range.step = (range.high - range.low) / (settings.places + 1);
  std::vector<double> places;
  for (int i = 1; i <= settings.places; ++i) places.push_back(range.low + i * range.step);
  for (const double share : {0.5, 0.25, 0.125}) {
    places.push_back(range.low + share * range.step);
    places.push_back(range.high - share * range.step);
  }
  const double least = range.step / (1 << settings.halvings);
  QuickFit best;
  for (const double factor : {1.0, 4.0, 16.0}) {
    const Model model = best_value(around, resized(around, start, factor), index, places, 1);
    QuickFit found = quick_fit(around, halved_to_best_place(around, model, index, range, least), 1);
    if (best.r.size() == 0 || found.objective < best.objective) best = std::move(found);
  }
  return best.model;
}

Model with_best_place(const Surroundings& around, const Model& model, std::size_t index,
                      const Range& range) {
  if (range.step == 0.0) return with_best_position(around, model, index, range);
  const double least = range.step / (1 << around.settings().fitting.halvings);
  return halved_to_best_place(around, model, index, range, least);
}

std::optional<std::size_t> index_of(const Candidate& effect, Role role) {
  for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
    if (effect.parameters[i].role == role) return i;
  }
  return std::nullopt;
}

/// An event as a whole first, then its end and its beginning by themselves: each edge shows at its
/// own instant.
Model with_best_event(const Surroundings& around, Model model, const Candidate& effect,
                      std::size_t from) {
  const double least = around.settings().fitting.event_resolution;
  const std::optional<std::size_t> duration = index_of(effect, Role::duration);
  const Range when = range_of_place(around, effect, from);
  model = with_best_place(around, model, from, when);
  if (!duration) return model;
  const Range length{effect.parameters[*duration].low, around.settings().data.shot_seconds,
                     when.step};
  for (int round = 0; round < 2; ++round) {
    model = halved_to_best_place(around, model, *duration, length, least * length.step);
    model = halved_to_best_place(around, model, from, when, least * when.step, duration);
  }
  return model;
}

/// What no derivative leads to (orders, places, events), searched for the last effect of `model`.
Model with_best_places(const Surroundings& around, Model model) {
  const Candidate& effect = (*around.library)[model.effects.back()];
  for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
    const Role role = effect.parameters[i].role;
    if (role == Role::order) model = with_best_order(around, model, i);
    if (role == Role::event) {
      model = with_best_event(around, std::move(model), effect, i);
      continue;
    }
    const Range range = range_of_place(around, effect, i);
    if (range.high > range.low) model = with_best_place(around, model, i, range);
  }
  return model;
}

bool has_places(const Candidate& effect) {
  return std::any_of(
      effect.parameters.begin(), effect.parameters.end(),
      [](const CandidateParameter& p) { return p.role != Role::size && p.role != Role::filter; });
}

/// `model`, or its last effect begun from another of these probes; then with one more limit on,
/// where that leaves less.
Model best_choice(const Surroundings& around, const Model& base, Model model,
                  const std::vector<std::size_t>& choices) {
  const int iterations = around.settings().fitting.first_iterations;
  const std::size_t candidate = model.effects.back().candidate;
  const Candidate& effect = (*around.library)[candidate];
  QuickFit least = quick_fit(around, model, iterations);
  const auto keep_better = [&](Model other) {
    QuickFit fitted = quick_fit(around, other, iterations);
    if (fitted.objective < least.objective) least = std::move(fitted), model = std::move(other);
  };
  for (const std::size_t probe : choices)
    if (probe != choices.front())
      keep_better(best_size(around, base, candidate, effect.probes[probe], 1.0));
  const std::vector<double> alone = least.model.effects.back().theta;
  for (const std::vector<double>& probe : effect.probes) {
    std::vector<double> both = alone;
    for (std::size_t i = 0; i < both.size(); ++i)
      if (effect.parameters[i].null == kOff) both[i] = std::min(both[i], probe[i]);
    if (choices_of(effect, both) != choices_of(effect, alone))
      keep_better(with(base, candidate, std::move(both)));
  }
  return model;
}

Surroundings only_shots(const Surroundings& around, const Model& model,
                        const std::vector<std::size_t>& kept) {
  const Problem& problem = around.problem;
  const Problem few = with_shots(problem, kept, around.settings().fitting.recalled);
  Eigen::MatrixXd A(static_cast<Eigen::Index>(few->size), around.A.cols());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    block_of(A, few->shots[i], 0, few->channels.size()) =
        block_of(around.A, problem->shots[kept[i]], 0, few->channels.size());
  }
  return {few, around.library, StartElimination(few, *around.library, model), std::move(A),
          around.shot_scale};
}

/// The shots in which an event that was probed at `t` can show, wherever its edges are put.
std::vector<std::size_t> shots_of_event(const Comparison& comparison, double t) {
  const double reach = comparison.settings.fitting.event_reach;
  std::vector<std::size_t> out;
  for (std::size_t s = 0; s < comparison.shots.size(); ++s) {
    const Shot& shot = comparison.shots[s];
    const std::vector<double>& clock = comparison.sources[shot.source].drive.t;
    const double from = clock[shot.window.first], length = clock[shot.window.last] - from;
    if (std::abs(t - from) < reach * length) out.push_back(s);
  }
  return out;
}

Model start_of(const Surroundings& around, const Model& base, std::size_t candidate,
               std::size_t strongest, double amount) {
  const Candidate& effect = (*around.library)[candidate];
  Model best = best_size(around, base, candidate, effect.probes[strongest], amount);
  const std::vector<std::size_t> choices = one_of_each_choice(effect, strongest);
  if (choices.size() > 1) best = best_choice(around, base, std::move(best), choices);
  return with_best_places(around, std::move(best));
}

}  // namespace

Surroundings some_shots(const Surroundings& around, const Model& model) {
  const FittingSettings& fitting = around.settings().fitting;
  const Problem& problem = around.problem;
  if (std::cmp_less(problem->shots.size(), fitting.thinned_from)) return around;
  std::vector<std::size_t> kept;
  const auto every = static_cast<std::size_t>(fitting.thinned_every);
  for (std::size_t s = every / 2; s < problem->shots.size(); s += every) kept.push_back(s);
  return only_shots(around, model, kept);
}

Model best_start(const Surroundings& around, const Model& base, std::size_t candidate,
                 const ProbeScore* probe) {
  const Candidate& effect = (*around.library)[candidate];
  const std::size_t strongest = probe != nullptr ? probe->probe : 0;
  const double amount = probe != nullptr ? probe->amount : 1.0;
  const std::optional<std::size_t> event = index_of(effect, Role::event);
  if (!event) return start_of(around, base, candidate, strongest, amount);
  const std::vector<std::size_t> kept =
      shots_of_event(*around.problem, effect.probes[strongest][*event]);
  if (kept.empty()) return start_of(around, base, candidate, strongest, amount);
  Model start = start_of(only_shots(around, base, kept), base, candidate, strongest, amount);
  // what the others came to there they did for a few shots
  return with(base, candidate, start.effects.back().theta);
}

Model best_start(const Surroundings& around, const Model& base, const ProbeScore& a,
                 const ProbeScore& b) {
  const Library& library = *around.library;
  const double share = around.settings().fitting.inside_bound;
  const double farthest = around.settings().fitting.farthest_start;
  const bool a_first = !has_places(library[a.candidate]);
  const ProbeScore &first = a_first ? a : b, &second = a_first ? b : a;
  const auto at = [&](const ProbeScore& p, double factor) {
    const Candidate& effect = library[p.candidate];
    return scaled(effect, effect.probes[p.probe],
                  factor * std::clamp(p.amount, -farthest, farthest), share);
  };
  Model best;
  double least = std::numeric_limits<double>::infinity();
  for (const double factor : {1.0, 0.3, 0.6, 1.6}) {
    Model trial =
        with(with(base, first.candidate, at(first, factor)), second.candidate, at(second, factor));
    const double energy = error_energy(around, trial);
    if (energy < least || best.effects.empty()) least = energy, best = std::move(trial);
  }
  return with_best_places(around, std::move(best));
}

}  // namespace sanso::diagnose
