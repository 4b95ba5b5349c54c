// What is fitted, what is held out, and errors before and after on what was held out.
#include "tools/diagnose/verdict/heldout.h"

#include <algorithm>
#include <cmath>
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

/// Sums over all joints; energies in rad^2 (m^2).
struct Sums {
  double before = 0.0, after = 0.0, noise = 0.0, rows = 0.0;
};

/// One horizon: RMS of each position channel, and of all.
std::map<std::string, FitScore> scores_of(const Problem& problem, const Eigen::VectorXd& before,
                                          const Eigen::VectorXd& after) {
  std::map<std::string, FitScore> out;
  Sums all;
  for (std::size_t c = 0; c < problem->channels.size(); ++c) {
    const Observed& channel = problem->channels[c];
    double b = 0.0, a = 0.0, rows = 0.0;
    for (const Shot& shot : problem->shots) {
      for (const double e : rows_of(before, shot, c)) b += e * e;
      for (const double e : rows_of(after, shot, c)) a += e * e;
      rows += static_cast<double>(shot.rows);
    }
    const double scale = problem.scales.sigma[c] * problem.scales.sigma[c];
    out["q:" + problem->joints[channel.joint]] = {std::sqrt(scale * b / rows),
                                                  std::sqrt(scale * a / rows), channel.noise};
    all.before += scale * b, all.after += scale * a,
        all.noise += channel.noise * channel.noise * rows, all.rows += rows;
  }
  out["all"] = {std::sqrt(all.before / all.rows), std::sqrt(all.after / all.rows),
                std::sqrt(all.noise / all.rows)};
  return out;
}

}  // namespace

double FitScore::explained() const {
  const double before = nominal * nominal - noise * noise,
               after = nominal * nominal - patched * patched;
  return before > 0.0 ? std::clamp(after / before, -1.0, 1.0) : 0.0;
}

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
                             const Model& patched, const Part& heldout, const Settings& settings) {
  HeldoutScores out;
  for (const auto& [name, seconds] :
       {std::pair<const char*, double>{"0.1", 0.1}, {"0.5", 0.5}, {"2", 2.0}}) {
    ProblemOptions options;
    options.shot_seconds = seconds;
    options.maximum_rows = 4 * settings.data.maximum_rows;
    options.secondary = false;
    const Problem problem = restricted(make_problem(sources, noise, options, settings), heldout);
    if (problem->shots.empty() || problem->channels.empty()) continue;
    out[name] = scores_of(problem, prediction_error(problem, library, Model{}),
                          prediction_error(problem, library, patched));
  }
  return out;
}

HeldoutProof prove(const std::vector<Source>& sources, const std::vector<NoiseLevel>& noise,
                   const Surroundings& around, const Model& final) {
  const Library& library = *around.library;
  const Split split = make_split(sources);
  const Problem fitted = restricted(around.problem, split.fitted);
  Surroundings around_fitted = make_surroundings(fitted, library, final);
  around_fitted.shot_scale = around.shot_scale;
  HeldoutProof out;
  out.model = fit(around_fitted, final, around.settings().fitting.iterations).model;
  out.scores = heldout_scores(sources, noise, library, out.model, split.heldout, around.settings());
  out.recordings = split.heldout_names;
  out.part = split.heldout;
  return out;
}

}  // namespace sanso::diagnose
