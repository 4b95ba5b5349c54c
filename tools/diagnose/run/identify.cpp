// Known effects and settings fitted to recordings: no search, no verdict.
#include "tools/diagnose/run/identify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/diagnose/effects/from_model.h"
#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {
namespace {

/// The library says which parameters are fitted: what model.toml has a key for, and the two
/// calibrations that every real robot needs.
std::vector<std::string> fitted_ids() {
  std::vector<std::string> ids;
  for (const Effect& e : library()) {
    if (std::any_of(e.identified.begin(), e.identified.end(),
                    [](Identified i) { return i != Identified::never; }))
      ids.emplace_back(e.id);
  }
  return ids;
}

/// One candidate a joint and effect. What is not fitted stays at its null.
Library one_by_one(const Comparison& comparison) {
  Library library;
  for (Candidate& c : place_library(comparison, fitted_ids()).candidates) {
    if (c.where.size() != 1) continue;
    const Effect& effect = *find_effect(c.effect);
    const Actuator actuator =
        comparison.sources.front().nominal.joints[c.joints[0]].nominal.actuator;
    bool any = false;
    for (std::size_t k = 0; k < c.parameters.size(); ++k) {
      const bool fitted = effect.fitted_by_identify(k, actuator);
      c.parameters[k].structural = c.parameters[k].structural || !fitted;
      any = any || fitted;
    }
    if (any) library.candidates.push_back(std::move(c));
  }
  return library;
}

/// All candidates at `share` of their typical size away from the null: inside the bounds, never on
/// one.
Model start_at(const Library& library, double share) {
  Model model;
  for (std::size_t c = 0; c < library.candidates.size(); ++c) {
    Chosen chosen{c, {}};
    for (const CandidateParameter& p : library[c].parameters) {
      const double away = p.structural ? 0.0 : share * p.typical;
      chosen.theta.push_back(p.null + away <= p.high ? p.null + away : p.null - away);
    }
    model.effects.push_back(std::move(chosen));
  }
  return model;
}

FitResult best_fit(const Surroundings& around, const Library& library) {
  FitResult best;
  best.objective = INFINITY;
  for (const double share :
       {0.1, 1.0}) {  // two starts: near the nominal model, and at sizes that occur in practice
    FitResult result =
        fit(around, start_at(library, share), 2 * around.settings().fitting.iterations);
    if (result.objective < best.objective) best = std::move(result);
  }
  return best;
}

/// Fits and linearises the starts anew around each answer, until an answer is as good as the one
/// before: a step that gains little in the objective can still be many standard deviations long
/// where parameters act alike.
FitResult settle(Surroundings& around, const Problem& problem, const Library& library,
                 FitResult result) {
  const FittingSettings& settings = problem->settings.fitting;
  for (int round = 0; round < settings.identify_rounds; ++round) {
    around = make_surroundings(problem, library, result.model);
    const double before = fit(around, result.model, 0).objective;
    result = fit(around, result.model, settings.iterations);
    if (before - result.objective < settings.identify_settled) break;
  }
  return result;
}

std::vector<IdentifiedParameter> parameters_of(const FitResult& result, const Library& library,
                                               double standard_errors) {
  std::vector<IdentifiedParameter> out;
  const std::vector<double> sigmas = parameter_sigmas(result, library);
  std::size_t i = 0;
  for (const Chosen& chosen : result.model.effects) {
    const Candidate& c = library[chosen];
    for (std::size_t k = 0; k < c.parameters.size(); ++k, ++i) {
      const CandidateParameter& p = c.parameters[k];
      if (p.structural) continue;
      IdentifiedParameter found{c.where[0],      c.effect,  p.name, p.unit, p.null,
                                chosen.theta[k], sigmas[i], false,  false};
      const double margin = 1e-6 * (p.high - p.low);
      const auto ends_at =
          [&](double bound) {  // the null is no bound: there the effect is simply absent
            return bound != p.null && std::abs(found.value - bound) <= margin;
          };
      found.at_bound = ends_at(p.low) || ends_at(p.high);
      found.determined = std::abs(found.value - p.null) > standard_errors * found.sigma;
      out.push_back(std::move(found));
    }
  }
  return out;
}

/// Settings where model.toml has a key for it, an [[effect]] where not.
void fold_in(ModelFolder& model, const IdentifiedParameter& p) {
  const Effect& effect = *find_effect(p.effect);
  const auto parameter =
      std::find_if(effect.parameters.begin(), effect.parameters.end(),
                   [&](const EffectParameter& q) { return q.name == p.parameter; });
  JointSettings& joint = model.joints[model.tree.index_of(p.joint)];
  const auto k = static_cast<std::size_t>(parameter - effect.parameters.begin());
  // more negative than a setting may be: a correction of the actuator's own
  if (!effect.fold_into(joint, k, p.value))
    model.effects.push_back({p.effect, {p.joint}, {{p.parameter, p.value}}, 0});
}

/// The model less what the data do not determine. `told`: its parameters, as parameters_of lists
/// them.
Model determined_part(const Model& model, const std::vector<IdentifiedParameter>& told) {
  Model out;
  std::size_t index = 0;
  for (const Chosen& chosen : model.effects) {
    if (told[index++].determined) out.effects.push_back(chosen);
  }
  return out;
}

}  // namespace

Identification identify(const ModelFolder& model, const LoadedRecordings& loaded,
                        const Settings& settings, const IdentifyProgress& progress) {
  const double standard_errors = settings.decisions.standard_errors;
  const std::vector<NoiseLevel>& noise = loaded.gate.noise;
  ProblemOptions options;
  options.maximum_rows = settings.data.maximum_rows;
  Problem problem = make_problem(make_sources(model, loaded.recordings, noise, settings), noise,
                                 options, settings);
  const Library library = one_by_one(*problem);
  progress(fmt::format("{} parameters, {} shots of {} s", library.candidates.size(),
                       problem->shots.size(), options.shot_seconds));

  Surroundings around = make_surroundings(problem, library, Model{});
  FitResult result = best_fit(around, library);
  // again around what was found: starts and spread of the errors are those of a good model
  problem.scales =
      overdispersed(problem, overdispersion(*problem, around.starts.project(result.r)));
  result = settle(around, problem, library, std::move(result));
  const FitResult nominal = fit(around, Model{}, 0);

  Identification out;
  out.model = model;
  out.parameters = parameters_of(result, library, standard_errors);
  progress("leave out what the data do not determine, fit again");
  result.model = determined_part(result.model, out.parameters);
  result = settle(around, problem, library, std::move(result));
  for (const IdentifiedParameter& p : parameters_of(result, library, standard_errors)) {
    for (IdentifiedParameter& shown : out.parameters) {
      if (shown.joint != p.joint || shown.effect != p.effect || shown.parameter != p.parameter)
        continue;
      // the spread stays that of the fit in which everything was free: leaving out rivals only
      // looks like certainty
      const double spread = std::max(shown.sigma, p.sigma);
      shown = p;
      shown.sigma = spread;
    }
    fold_in(out.model, p);
  }
  const double before = around.starts.energy_by_shot(nominal.r).sum();
  if (before > 0.0) out.error_left = heldout_energy(around, result).sum() / before;
  return out;
}

int run_identify(const std::string& model_folder, const std::vector<std::string>& files,
                 const std::string& out, const Settings& settings) {
  try {
    const ModelFolder model = read_model_folder(model_folder);
    require_fixed_base(model, "sanso identify");
    const LoadedRecordings loaded = load_recordings(files, gate_joints(model), settings.gate);
    for (const Defect& d : loaded.gate.defects) {
      fmt::print(stderr, "refused    {} {}{}: {}: {}\n", d.file, d.channel,
                 d.row >= 0 ? fmt::format(" row {}", d.row) : "", d.defect, d.message);
    }
    if (loaded.gate.refused()) return 2;
    const Identification found = identify(model, loaded, settings, [](const std::string& line) {
      fmt::print(stderr, "identify   {}\n", line);
    });
    fmt::print("{:<16} {:<18} {:<14} {:>12} {:>12} {:<10}\n", "joint", "effect", "parameter",
               "value", "+- 2 sigma", "unit");
    for (const IdentifiedParameter& p : found.parameters) {
      fmt::print("{:<16} {:<18} {:<14} {:>12.5g} {:>12.2g} {:<10} {}{}\n", p.joint, p.effect,
                 p.parameter, p.value, 2 * p.sigma, p.unit,
                 p.determined ? "" : "not determined by these data: left as it was",
                 p.at_bound ? "(ended at its bound)" : "");
    }
    fmt::print("held out   {:.1f} % of the nominal model's error energy at 0.5 s is left\n",
               100 * found.error_left);
    if (found.error_left >= 1.0) {
      fmt::print(
          "warning    on data not used for the fit this model is worse than the nominal one: the "
          "recordings are too "
          "few or "
          "too different for these settings. Do not use it; record more, or run sanso diagnose.\n");
    }
    write_model_folder(found.model, out);
    fmt::print("model      {}\n", out);
    return 0;
  } catch (const files::InputError& e) {
    fmt::print(stderr, "sanso identify: {}\n", e.what());
    return 2;
  }
}

}  // namespace sanso::diagnose
