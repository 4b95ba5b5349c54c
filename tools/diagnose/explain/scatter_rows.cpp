// Rows, caps and regressions of squared errors.
#include "tools/diagnose/explain/scatter_rows.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {

using Eigen::Index;
using Eigen::VectorXd;

namespace {

/// The rows of a piece in a stacked vector.
template <class Stacked>
auto rows_of(Stacked&& stacked, const Comparison& comparison, const Piece& piece) {
  return diagnose::rows_of(stacked, comparison.shots[piece.shot], piece.channel);
}

/// Mean of a channel's entries, by channel.
std::vector<double> means(const Comparison& comparison, const std::vector<Piece>& pieces,
                          const VectorXd& x) {
  std::vector<double> sum(comparison.channels.size(), 0.0), count(comparison.channels.size(), 0.0);
  for (const Piece& p : pieces) {
    sum[p.channel] += rows_of(x, comparison, p).sum();
    count[p.channel] += static_cast<double>(comparison.shots[p.shot].rows);
  }
  for (std::size_t c = 0; c < sum.size(); ++c) sum[c] /= std::max(count[c], 1.0);
  return sum;
}

}  // namespace

std::vector<Piece> pieces_of(const Comparison& comparison) {
  std::vector<Piece> out;
  for (std::size_t s = 0; s < comparison.shots.size(); ++s) {
    for (std::size_t c = 0; c < comparison.channels.size(); ++c) out.push_back({s, c});
  }
  return out;
}

Eigen::VectorXd variance_of(const std::vector<Eigen::VectorXd>& draws) {
  const auto count = static_cast<double>(draws.size());
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(draws.front().size()), square = sum;
  for (const Eigen::VectorXd& x : draws) sum += x, square += x.cwiseAbs2();
  return (square - sum.cwiseAbs2() / count).cwiseMax(0.0) / (count - 1.0);
}

VectorXd rough_part(const Comparison& comparison, const VectorXd& x) {
  VectorXd out = VectorXd::Zero(x.size());
  for (const Piece& p : pieces_of(comparison)) {
    const auto rows = rows_of(x, comparison, p);
    if (rows.size() < 3) continue;
    const Index inner = rows.size() - 2;
    rows_of(out, comparison, p).segment(1, inner) =
        rows.segment(1, inner) - 0.5 * (rows.head(inner) + rows.tail(inner));
  }
  return out;
}

VectorXd capped(const Comparison& comparison, const std::vector<Piece>& pieces, const VectorXd& x) {
  VectorXd out = x;
  for (std::size_t c = 0; c < comparison.channels.size(); ++c) {
    std::vector<double> values;
    for (const Piece& p : pieces) {
      const auto rows = rows_of(x, comparison, p);
      if (p.channel == c) values.insert(values.end(), rows.begin(), rows.end());
    }
    const double cap = quantile(values, 1.0 - comparison.settings.chance.capped_share);
    for (const Piece& p : pieces) {
      if (p.channel == c) rows_of(out, comparison, p) = rows_of(out, comparison, p).cwiseMin(cap);
    }
  }
  return out;
}

double scatter_score(const Comparison& comparison, const std::vector<Piece>& pieces,
                     const VectorXd& squares, const VectorXd& expected) {
  const std::vector<double> square = means(comparison, pieces, squares),
                            scatter = means(comparison, pieces, expected);
  double covariance = 0.0, variance = 0.0;
  for (const Piece& p : pieces) {
    const double mean = square[p.channel];
    if (!(mean > 0.0)) continue;
    const auto v = rows_of(expected, comparison, p).array() - scatter[p.channel];
    // a channel counts by its precision: scatter of a noisy channel says little
    covariance += (v * (rows_of(squares, comparison, p).array() / mean - 1.0)).sum() / mean;
    variance += 2.0 * v.square().sum() / (mean * mean);
  }
  return variance > 0.0 ? covariance / std::sqrt(variance) : 0.0;
}

double ScatterShare::over(const std::vector<std::size_t>& shots) const {
  double above = 0.0, below = 0.0;
  for (const std::size_t i : shots) above += covariance[i], below += variance[i];
  return below > 0.0 ? above / below : 0.0;
}

ScatterShare scatter_share(const Comparison& comparison, const std::vector<Piece>& pieces,
                           const VectorXd& squares, const VectorXd& expected, int draws) {
  const std::vector<double> square = means(comparison, pieces, squares),
                            scatter = means(comparison, pieces, expected);
  ScatterShare out{std::vector<double>(comparison.shots.size(), 0.0),
                   std::vector<double>(comparison.shots.size(), 0.0)};
  for (const Piece& p : pieces) {
    const double mean = square[p.channel];
    if (!(mean > 0.0)) continue;
    const auto v = rows_of(expected, comparison, p).array() - scatter[p.channel];
    out.covariance[p.shot] +=
        (v * (rows_of(squares, comparison, p).array() - mean)).sum() / (mean * mean);
    // squares of a variance from few draws are too large by (draws + 1) / (draws - 1)
    const double centre = scatter[p.channel], honest = (draws - 1.0) / (draws + 1.0);
    out.variance[p.shot] += (honest * rows_of(expected, comparison, p).squaredNorm() -
                             static_cast<double>(comparison.shots[p.shot].rows) * centre * centre) /
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
