// What is fitted, what is held out, and errors before and after on what was held out.
#include "tools/diagnose/verdict/heldout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

namespace sanso::diagnose {
namespace {

bool inside(const Comparison& comparison, const Shot& shot, const Part& part) {
  const std::size_t s = shot.source;
  const std::vector<double>& t = comparison.sources[s].drive.t;
  const double length = std::max(t.back() - t.front(), 1e-9);
  const double from = (t[shot.window.first] - t.front()) / length,
               until = (t[shot.window.last] - t.front()) / length;
  return from >= part.from[s] - 1e-9 && until <= part.until[s] + 1e-9;
}

std::string stem(const std::string& file) { return std::filesystem::path(file).stem().string(); }

/// Whitened errors of every model at one horizon; stacked.
struct Errors {
  Eigen::VectorXd nominal, patched, named, baseline;
};

/// Error of a joint that goes on at the speed of its start, by the layout of `like`.
Eigen::VectorXd constant_velocity_error(const Problem& problem, const Eigen::VectorXd& like) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(like.size());
  for (const Shot& shot : problem->shots) {
    const Source& source = problem->sources[shot.source];
    const double start = source.drive.t[shot.window.first];
    for (std::size_t c = 0; c < problem->channels.size(); ++c) {
      const Observed& channel = problem->channels[c];
      if (channel.signal != Signal::q) continue;
      for (std::size_t k = 0; k < shot.rows; ++k) {
        const std::size_t row = recorded_row(shot, k);
        const double predicted = shot.window.q[channel.joint] +
                                 shot.window.dq[channel.joint] * (source.drive.t[row] - start);
        const double error = measured(source, channel, row) - predicted;
        if (std::isfinite(error))
          rows_of(out, shot, c)[static_cast<Eigen::Index>(k)] = error / problem.scales.sigma[c];
      }
    }
  }
  return out;
}

/// Squared errors by model, rad^2 (m^2).
struct Sums {
  double nominal = 0.0, patched = 0.0, named = 0.0, baseline = 0.0, noise = 0.0, rows = 0.0;

  FitScore score() const {
    const auto root = [&](double sum) { return std::sqrt(sum / rows); };
    return {root(nominal), root(patched), root(noise), root(baseline), root(named)};
  }
};

Sums sums_of(const Problem& problem, const Errors& errors, std::size_t c) {
  Sums out;
  const double scale = problem.scales.sigma[c] * problem.scales.sigma[c];
  const double noise = problem->channels[c].noise;
  for (const Shot& shot : problem->shots) {
    out.nominal += scale * rows_of(errors.nominal, shot, c).squaredNorm();
    out.patched += scale * rows_of(errors.patched, shot, c).squaredNorm();
    out.named += scale * rows_of(errors.named, shot, c).squaredNorm();
    out.baseline += scale * rows_of(errors.baseline, shot, c).squaredNorm();
    out.rows += static_cast<double>(shot.rows);
  }
  out.noise = noise * noise * out.rows;
  return out;
}

/// One horizon: RMS of each position channel, and of all.
HorizonScores scores_of(const Problem& problem, const Errors& errors) {
  HorizonScores out;
  Sums all;
  for (std::size_t c = 0; c < problem->channels.size(); ++c) {
    const Sums s = sums_of(problem, errors, c);
    out.channels["q:" + problem->joints[problem->channels[c].joint]] = s.score();
    all.nominal += s.nominal, all.patched += s.patched, all.named += s.named;
    all.baseline += s.baseline, all.noise += s.noise, all.rows += s.rows;
  }
  out.all = all.score();
  return out;
}

/// Horizons, and their exact s.
std::map<Horizon, double> horizons(double users) {
  std::map<Horizon, double> out;
  for (const double seconds : kHorizons_s) out[Horizon::ahead(seconds)] = seconds;
  out[Horizon::ahead(users)] = users;
  return out;
}

/// What of a model has a name.
Model named_part(const Model& model, const std::vector<char>& named) {
  Model out = model;
  out.effects.clear();
  for (std::size_t i = 0; i < model.effects.size(); ++i) {
    if (named[i] != 0) out.effects.push_back(model.effects[i]);
  }
  return out;
}

}  // namespace

double FitScore::explained() const { return explained_by(patched); }

double FitScore::explained_by(double error) const {
  const double before = nominal * nominal - noise * noise,
               after = nominal * nominal - error * error;
  return before > 0.0 ? std::clamp(after / before, -1.0, 1.0) : 0.0;
}

Horizon Horizon::ahead(double seconds) {
  Horizon out;
  out.seconds_ = seconds;
  out.seconds_ = std::strtod(out.text().c_str(), nullptr);
  return out;
}

std::string Horizon::text() const { return fmt::format("{:.3g}", seconds_); }

Split make_split(const std::vector<Source>& sources) {
  const std::size_t n = sources.size();
  Split split;
  split.fitted.from.assign(n, 0.0), split.fitted.until.assign(n, 1.0);
  split.heldout.from.assign(n, 0.0), split.heldout.until.assign(n, 0.0);
  std::map<std::string, std::vector<std::size_t>> conditions;
  for (std::size_t i = 0; i < n; ++i) conditions[sources[i].condition].push_back(i);
  std::vector<std::size_t> held;
  if (conditions.size() > 1) {
    const auto smallest = std::min_element(
        conditions.begin(), conditions.end(),
        [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
    held = smallest->second;
  } else if (n >= 2) {
    for (std::size_t i = n - 1; held.size() < std::max<std::size_t>(1, n / 3);
         i -= std::min<std::size_t>(i, 3))
      held.push_back(i);
  }
  for (std::size_t i : held) {
    split.heldout.until[i] = 1.0;
    split.fitted.until[i] = 0.0;
    split.heldout_names.push_back(stem(sources[i].file));
  }
  if (held.empty()) {  // one recording: its last third
    split.fitted.until[0] = split.heldout.from[0] = 2.0 / 3.0;
    split.heldout.until[0] = 1.0;
    split.heldout_names.push_back(stem(sources[0].file) + ", last third");
    split.last_part = true;
  }
  return split;
}

Problem restricted(const Problem& problem, const Part& part) {
  std::vector<std::size_t> kept;
  for (std::size_t s = 0; s < problem->shots.size(); ++s) {
    if (inside(*problem, problem->shots[s], part)) kept.push_back(s);
  }
  return kept.empty() ? problem : with_shots(problem, kept);
}

HeldoutScores heldout_scores(const std::vector<Source>& sources,
                             const std::vector<NoiseLevel>& noise, const Library& library,
                             const Explained& models, const Part& heldout,
                             const Settings& settings) {
  HeldoutScores out;
  for (const auto& [horizon, seconds] : horizons(settings.remains.horizon)) {
    ProblemOptions options;
    options.shot_seconds = seconds;
    options.maximum_rows = 4 * settings.data.maximum_rows;
    options.secondary = false;
    const Problem problem = restricted(make_problem(sources, noise, options, settings), heldout);
    if (problem->shots.empty() || problem->channels.empty()) continue;
    Errors errors{prediction_error(problem, library, Model{}),
                  prediction_error(problem, library, models.patched),
                  {},
                  {}};
    const bool all_named = models.named.effects.size() == models.patched.effects.size();
    errors.named = all_named ? errors.patched : prediction_error(problem, library, models.named);
    errors.baseline = constant_velocity_error(problem, errors.nominal);
    out[horizon] = scores_of(problem, errors);
  }
  return out;
}

HeldoutProof prove(const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
                   const Surroundings& around, const Model& final, const std::vector<char>& named) {
  const Library& library = *around.library;
  const Split split = make_split(sources);
  const Problem fitted = restricted(around.problem, split.fitted);
  Surroundings around_fitted = make_surroundings(fitted, library, final);
  around_fitted.shot_scale = around.shot_scale;
  const auto refitted = [&](const Model& model) {
    return fit(around_fitted, model, around.settings().fitting.iterations).model;
  };
  HeldoutProof out;
  out.model = refitted(final);
  Explained models{out.model, out.model};
  const Model part = named_part(final, named);
  if (part.effects.size() < final.effects.size()) models.named = refitted(part);
  out.scores = heldout_scores(sources, noise, library, models, split.heldout, around.settings());
  out.recordings = split.heldout_names;
  out.last_part = split.last_part;
  out.part = split.heldout;
  return out;
}

}  // namespace sanso::diagnose
