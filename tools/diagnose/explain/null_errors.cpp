// Draws of the two null laws.
#include "tools/diagnose/explain/null_errors.h"

#include <algorithm>
#include <cmath>

namespace sanso::diagnose {

using Eigen::Index;
using Eigen::VectorXd;

VectorXd shifted(const Problem& problem, const std::vector<Piece>& pieces, const VectorXd& x,
                 Random& random) {
  VectorXd out = x;
  std::size_t from = 0;
  while (from < pieces.size()) {
    const int source = problem.shots[pieces[from].shot].source;
    std::size_t until = from;
    while (until < pieces.size() && problem.shots[pieces[until].shot].source == source) ++until;
    const double share = random.uniform();
    for (std::size_t c = 0; c < problem.channels.size(); ++c) {
      std::vector<Index> at;
      for (std::size_t i = from; i < until; ++i) {
        if (pieces[i].channel != c) continue;
        for (Index k = 0; k < pieces[i].rows; ++k) at.push_back(pieces[i].from + k);
      }
      const auto by = static_cast<std::size_t>(share * static_cast<double>(at.size()));
      for (std::size_t k = 0; k < at.size(); ++k) out[at[k]] = x[at[(k + by) % at.size()]];
    }
    from = until;
  }
  return out;
}

VectorXd simulated_error(const Problem& problem, const VectorXd& r, Random& random) {
  VectorXd out(r.size());
  for (const Shot& shot : problem.shots) {
    const Source& source = problem.sources[static_cast<std::size_t>(shot.source)];
    for (std::size_t c = 0; c < problem.channels.size(); ++c) {
      const Observed& channel = problem.channels[c];
      const double step = channel.quantum;
      const double noise =
          std::sqrt(std::max(0.0, channel.noise * channel.noise - step * step / 12.0));
      for (std::size_t k = 0; k < shot.rows; ++k) {
        const auto at = static_cast<Index>(shot.offset + c * shot.rows + k);
        const std::size_t row = shot.window.first + (k + 1) * static_cast<std::size_t>(shot.stride);
        const double reading = measured(source, channel, row);
        if (!std::isfinite(reading)) {
          out[at] = 0.0;
          continue;
        }
        const double predicted = reading - channel.sigma * r[at];
        double drawn = predicted + noise * random.normal();
        if (step > 0.0) drawn = step * std::round(drawn / step);
        out[at] = (drawn - predicted) / channel.sigma;
      }
    }
  }
  return out;
}

}  // namespace sanso::diagnose
