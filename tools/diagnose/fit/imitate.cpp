// Gauss-Newton on the difference of two predictions, starts eliminated, inside the bounds.
#include "tools/diagnose/fit/imitate.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace sanso::diagnose {
namespace {

class Imitator {
 public:
  Imitator(const Surroundings& around, const FitResult& goal, std::size_t place,
           std::size_t candidate)
      : around_(around), goal_(goal), effect_((*around.library)[candidate]), rest_(goal.model) {
    rest_.effects.erase(rest_.effects.begin() + static_cast<std::ptrdiff_t>(place));
    rest_.effects.push_back({candidate, {}});
    for (std::size_t k = 0; k < effect_.parameters.size(); ++k) {
      if (!effect_.parameters[k].structural) free_.push_back(k);
    }
  }

  struct Point {
    std::vector<double> theta;
    Eigen::VectorXd d;  // difference of the predictions
    double distance = INFINITY;
  };

  Point at(std::vector<double> theta) const {
    for (std::size_t k = 0; k < theta.size(); ++k)
      theta[k] = std::clamp(theta[k], effect_.parameters[k].low, effect_.parameters[k].high);
    Point out;
    out.d = prediction_error(around_.problem, *around_.library, with(theta)) - goal_.r;
    out.distance = around_.bounded(around_.starts.energy_by_shot(out.d)).sum();
    out.theta = std::move(theta);
    return out;
  }

  Model with(const std::vector<double>& theta) const {
    Model out = rest_;
    out.effects.back().theta = theta;
    return out;
  }

  /// Where to begin: as told, and the library's probes at several sizes.
  Point best_start(const std::vector<double>& told) const {
    Point best = at(told);
    for (const std::vector<double>& probe : effect_.probes) {
      for (const double factor : {0.5, 2.0, -1.0}) {
        std::vector<double> theta = probe;
        for (const std::size_t k : free_) {
          const double null = effect_.parameters[k].null;
          theta[k] = null + factor * (probe[k] - null);
        }
        Point trial = at(std::move(theta));
        if (trial.distance < best.distance) best = std::move(trial);
      }
    }
    return best;
  }

  /// One step, halved until it comes closer; false: it does not.
  bool step(Point& from) const {
    if (free_.empty()) return false;  // what is structural stays as the probe says
    const auto n = static_cast<Eigen::Index>(free_.size());
    Eigen::MatrixXd columns(from.d.size(), n + 1);
    for (Eigen::Index i = 0; i < n; ++i) {
      const std::size_t k = free_[static_cast<std::size_t>(i)];
      const CandidateParameter& p = effect_.parameters[k];
      std::vector<double> moved = from.theta;
      double length = around_.settings().fitting.derivative_step * p.typical;
      if (moved[k] + length > p.high) length = -length;
      moved[k] += length;
      const Eigen::VectorXd there =
          prediction_error(around_.problem, *around_.library, with(moved)) - goal_.r;
      columns.col(i) = (there - from.d) * (p.typical / length);
    }
    columns.col(n) = from.d;
    const Eigen::MatrixXd gram =
        around_.starts.gram(columns, around_.weights(around_.starts.energy_by_shot(from.d)));
    Eigen::MatrixXd H = gram.topLeftCorner(n, n);
    H.diagonal().array() += 1e-9 * (1.0 + H.diagonal().maxCoeff());
    const Eigen::VectorXd whole = -H.ldlt().solve(gram.topRightCorner(n, 1));
    for (const double share : {1.0, 0.5, 0.25, 0.1}) {
      std::vector<double> theta = from.theta;
      for (Eigen::Index i = 0; i < n; ++i) {
        const std::size_t k = free_[static_cast<std::size_t>(i)];
        theta[k] += share * whole[i] * effect_.parameters[k].typical;
      }
      Point trial = at(std::move(theta));
      if (trial.distance >= from.distance) continue;
      from = std::move(trial);
      return true;
    }
    return false;
  }

 private:
  const Surroundings& around_;
  const FitResult& goal_;
  const Candidate& effect_;
  Model rest_;
  std::vector<std::size_t> free_;
};

}  // namespace

Imitation imitate(const Surroundings& around, const FitResult& goal, std::size_t place,
                  const Chosen& other) {
  const Imitator imitator(around, goal, place, other.candidate);
  Imitator::Point at = imitator.best_start(other.theta);
  const FittingSettings& settings = around.settings().fitting;
  for (int i = 0; i < settings.iterations; ++i) {
    const double before = at.distance;
    if (!imitator.step(at) || before - at.distance < settings.converged * before) break;
  }
  return {imitator.with(at.theta), at.distance};
}

}  // namespace sanso::diagnose
