// What all fits around one model share, and how shots are weighed there.
#include <algorithm>
#include <cmath>
#include <vector>

#include "tools/diagnose/compare/parallel.h"
#include "tools/diagnose/fit/fit.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {

Surroundings make_surroundings(const Problem& problem, const Library& library, const Model& model) {
  Surroundings s{problem, &library, StartElimination(problem, library, model), {}};
  const std::size_t count = library.nuisances.size();
  s.A.resize(problem->size, count);
  const Remembered known(problem, library, model);
  const Eigen::VectorXd base = prediction_error_near(
      problem, library, model, Eigen::VectorXd::Zero(problem->size), {}, {}, &known);
  parallel_for(count, [&](std::size_t i) {
    Model moved = model;
    moved.nuisance.resize(library.nuisances.size(), 0.0);
    const double step = library.nuisances[i].tolerance;
    moved.nuisance[i] += step;
    s.A.col(i) = prediction_error_near(problem, library, moved, base, library.nuisances[i].joints,
                                       {}, &known) -
                 base;
  });
  return s;
}

void Surroundings::set_shot_scale(const Eigen::VectorXd& energy_by_shot) {
  std::vector<double> mean_square;
  for (std::size_t s = 0; s < problem->shots.size(); ++s) {
    const double rows = static_cast<double>(problem->shots[s].rows * problem->channels.size());
    mean_square.push_back(energy_by_shot[s] / rows);
  }
  const double outlier = settings().decisions.shot_outlier;
  shot_scale = outlier * outlier * std::max(1.0, median(mean_square));
}

Eigen::VectorXd Surroundings::bounded(const Eigen::VectorXd& energy_by_shot) const {
  Eigen::VectorXd out = energy_by_shot;
  for (std::size_t s = 0; s < problem->shots.size(); ++s) {
    const Shot& shot = problem->shots[s];
    const double scale = shot_scale * static_cast<double>(shot.rows * problem->channels.size());
    double& e = out[s];
    if (scale > 0.0) e = scale * std::log1p(std::max(e, 0.0) / scale);
    if (leaves_out(shot)) e = 0.0;
  }
  return out;
}

Eigen::VectorXd Surroundings::weights(const Eigen::VectorXd& energy_by_shot) const {
  Eigen::VectorXd out = Eigen::VectorXd::Ones(energy_by_shot.size());
  for (std::size_t s = 0; s < problem->shots.size(); ++s) {
    const Shot& shot = problem->shots[s];
    const double scale = shot_scale * static_cast<double>(shot.rows * problem->channels.size());
    double& weight = out[s];
    if (scale > 0.0) weight = 1.0 / (1.0 + std::max(energy_by_shot[s], 0.0) / scale);
    if (leaves_out(shot)) weight = 0.0;
  }
  return out;
}

}  // namespace sanso::diagnose
