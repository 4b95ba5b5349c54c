// Rows, caps and regressions of squared errors.
#include "tools/diagnose/explain/scatter_rows.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// Mean of a channel's entries, by channel.
std::vector<double> means(const Problem& problem, const std::vector<Piece>& pieces,
                          const VectorXd& x) {
  std::vector<double> sum(problem.channels.size(), 0.0), count(problem.channels.size(), 0.0);
  for (const Piece& p : pieces) {
    sum[p.channel] += x.segment(p.from, p.rows).sum();
    count[p.channel] += static_cast<double>(p.rows);
  }
  for (std::size_t c = 0; c < sum.size(); ++c) sum[c] /= std::max(count[c], 1.0);
  return sum;
}

}  // namespace

std::vector<Piece> pieces_of(const Problem& problem) {
  std::vector<Piece> out;
  for (std::size_t s = 0; s < problem.shots.size(); ++s) {
    const Shot& shot = problem.shots[s];
    for (std::size_t c = 0; c < problem.channels.size(); ++c) {
      out.push_back(
          {static_cast<Index>(shot.offset + c * shot.rows), static_cast<Index>(shot.rows), c, s});
    }
  }
  return out;
}

VectorXd rough_part(const Problem& problem, const VectorXd& x) {
  VectorXd out = VectorXd::Zero(x.size());
  for (const Piece& p : pieces_of(problem)) {
    if (p.rows < 3) continue;
    const Index inner = p.rows - 2;
    out.segment(p.from + 1, inner) =
        x.segment(p.from + 1, inner) -
        0.5 * (x.segment(p.from, inner) + x.segment(p.from + 2, inner));
  }
  return out;
}

VectorXd capped(const Problem& problem, const std::vector<Piece>& pieces, const VectorXd& x) {
  VectorXd out = x;
  for (std::size_t c = 0; c < problem.channels.size(); ++c) {
    std::vector<double> values;
    for (const Piece& p : pieces) {
      if (p.channel == c)
        values.insert(values.end(), x.data() + p.from, x.data() + p.from + p.rows);
    }
    const double cap = quantile(values, 1.0 - problem.settings.chance.capped_share);
    for (const Piece& p : pieces) {
      if (p.channel == c) out.segment(p.from, p.rows) = out.segment(p.from, p.rows).cwiseMin(cap);
    }
  }
  return out;
}

double scatter_score(const Problem& problem, const std::vector<Piece>& pieces,
                     const VectorXd& squares, const VectorXd& expected) {
  const std::vector<double> square = means(problem, pieces, squares),
                            scatter = means(problem, pieces, expected);
  double covariance = 0.0, variance = 0.0;
  for (const Piece& p : pieces) {
    const double mean = square[p.channel];
    if (!(mean > 0.0)) continue;
    const auto v = expected.segment(p.from, p.rows).array() - scatter[p.channel];
    // a channel counts by its precision: scatter of a noisy channel says little
    covariance += (v * (squares.segment(p.from, p.rows).array() / mean - 1.0)).sum() / mean;
    variance += 2.0 * v.square().sum() / (mean * mean);
  }
  return variance > 0.0 ? covariance / std::sqrt(variance) : 0.0;
}

double ScatterShare::over(const std::vector<std::size_t>& shots) const {
  double above = 0.0, below = 0.0;
  for (const std::size_t i : shots) above += covariance[i], below += variance[i];
  return below > 0.0 ? above / below : 0.0;
}

ScatterShare scatter_share(const Problem& problem, const std::vector<Piece>& pieces,
                           const VectorXd& squares, const VectorXd& expected, int draws) {
  const std::vector<double> square = means(problem, pieces, squares),
                            scatter = means(problem, pieces, expected);
  ScatterShare out{std::vector<double>(problem.shots.size(), 0.0),
                   std::vector<double>(problem.shots.size(), 0.0)};
  for (const Piece& p : pieces) {
    const double mean = square[p.channel];
    if (!(mean > 0.0)) continue;
    const auto v = expected.segment(p.from, p.rows).array() - scatter[p.channel];
    out.covariance[p.shot] +=
        (v * (squares.segment(p.from, p.rows).array() - mean)).sum() / (mean * mean);
    // squares of a variance from few draws are too large by (draws + 1) / (draws - 1)
    const double centre = scatter[p.channel], honest = (draws - 1.0) / (draws + 1.0);
    out.variance[p.shot] += (honest * expected.segment(p.from, p.rows).squaredNorm() -
                             static_cast<double>(p.rows) * centre * centre) /
                            (mean * mean);
  }
  return out;
}

double size_at_unit_share(const std::vector<double>& sizes, const std::vector<double>& share) {
  // variance ~ size^2
  if (share.front() <= 1.0) return sizes.front() * std::sqrt(std::max(0.0, share.front()));
  for (std::size_t i = 1; i < sizes.size(); ++i) {
    if (share[i] > 1.0) continue;
    const double low = std::log(share[i - 1]), high = std::log(std::max(share[i], 1e-3));
    const double t = low / std::max(low - high, 1e-9);
    return sizes[i - 1] * std::pow(sizes[i] / sizes[i - 1], t);
  }
  return sizes.back();
}

}  // namespace sanso::diagnose
