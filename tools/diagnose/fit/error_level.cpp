// How large what is left of an error is: in noise levels, and beyond what its model of noise says.
#include <algorithm>
#include <cmath>

#include "tools/diagnose/fit/fit.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/series.h"

namespace sanso::diagnose {

double position_error_level(const Surroundings& around, const Eigen::VectorXd& r,
                            const Eigen::VectorXd& expected_scatter) {
  const Problem& problem = around.problem;
  const Eigen::VectorXd projected = around.starts.project(r);
  const Eigen::VectorXd weights = around.weights(around.starts.energy_by_shot(r));
  double square = 0.0, rows = 0.0;
  for (std::size_t c = 0; c < problem->channels.size(); ++c) {
    const Observed& channel = problem->channels[c];
    if (channel.signal != Signal::q) continue;
    const double sigma = problem.scales.sigma[c];
    const double unit = sigma * sigma / (channel.floor * channel.floor);
    for (std::size_t s = 0; s < problem->shots.size(); ++s) {
      const Shot& shot = problem->shots[s];
      const double weight = weights[s];
      Eigen::ArrayXd squares = unit * rows_of(projected, shot, c).array().square();
      if (expected_scatter.size() > 0)
        squares /= 1.0 + unit * rows_of(expected_scatter, shot, c).array().max(0.0);
      square += weight * squares.sum();
      rows += weight * static_cast<double>(shot.rows);
    }
  }
  return rows > 0.0 ? std::sqrt(square / rows) : 0.0;
}

std::vector<double> overdispersion(const Comparison& comparison, const Eigen::VectorXd& projected) {
  std::vector<double> out;
  for (std::size_t c = 0; c < comparison.channels.size(); ++c) {
    std::vector<double> values;
    for (const Shot& shot : comparison.shots) {
      const auto rows = rows_of(projected, shot, c);
      const std::span<const double> piece(rows.data(), shot.rows);
      const double mean_square = rms(piece) * rms(piece);
      if (mean_square > 0.0) values.push_back(mean_square * autocorrelation_time(piece));
    }
    out.push_back(values.empty() ? 1.0 : std::max(1e-6, median(values)));
  }
  return out;
}

}  // namespace sanso::diagnose
