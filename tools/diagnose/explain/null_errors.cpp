// Draws of the two null laws.
#include "tools/diagnose/explain/null_errors.h"

#include <algorithm>
#include <cmath>

namespace sanso::diagnose {

using Eigen::VectorXd;

VectorXd shifted(const Comparison& comparison, const std::vector<Piece>& pieces, const VectorXd& x,
                 Random& random) {
  VectorXd out = x;
  std::size_t from = 0;
  while (from < pieces.size()) {
    const std::size_t source = comparison.shots[pieces[from].shot].source;
    std::size_t until = from;
    while (until < pieces.size() && comparison.shots[pieces[until].shot].source == source) ++until;
    const double share = random.uniform();
    for (std::size_t c = 0; c < comparison.channels.size(); ++c) {
      std::vector<double> values;
      for (std::size_t i = from; i < until; ++i) {
        if (pieces[i].channel != c) continue;
        for (const double e : rows_of(x, comparison.shots[pieces[i].shot], c)) values.push_back(e);
      }
      auto next = static_cast<std::size_t>(share * static_cast<double>(values.size()));
      for (std::size_t i = from; i < until; ++i) {
        if (pieces[i].channel != c) continue;
        for (double& e : rows_of(out, comparison.shots[pieces[i].shot], c))
          e = values[next++ % values.size()];
      }
    }
    from = until;
  }
  return out;
}

VectorXd simulated_error(const Problem& problem, const VectorXd& r, Random& random) {
  VectorXd out(r.size());
  for (const Shot& shot : problem->shots) {
    const Source& source = problem->sources[shot.source];
    for (std::size_t c = 0; c < problem->channels.size(); ++c) {
      const Observed& channel = problem->channels[c];
      const double step = channel.quantum;
      const double noise =
          std::sqrt(std::max(0.0, channel.noise * channel.noise - step * step / 12.0));
      const double sigma = problem.scales.sigma[c];
      const auto error = rows_of(r, shot, c);
      auto drawn_error = rows_of(out, shot, c);
      for (std::size_t k = 0; k < shot.rows; ++k) {
        const double reading = measured(source, channel, recorded_row(shot, k));
        if (!std::isfinite(reading)) {
          drawn_error[k] = 0.0;
          continue;
        }
        const double predicted = reading - sigma * error[k];
        double drawn = predicted + noise * random.normal();
        if (step > 0.0) drawn = step * std::round(drawn / step);
        drawn_error[k] = (drawn - predicted) / sigma;
      }
    }
  }
  return out;
}

}  // namespace sanso::diagnose
