// Penalised cubic B-splines on uniform knots.
#include "tools/diagnose/stats/curve.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {

ShapeCurve shape_curve(std::span<const double> x, std::span<const double> y, int bins,
                       double dependence) {
  ShapeCurve curve;
  std::vector<std::pair<double, double>> rows;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) {
    if (std::isfinite(x[i]) && std::isfinite(y[i])) rows.emplace_back(x[i], y[i]);
  }
  if (rows.size() < 10) return curve;
  std::sort(rows.begin(), rows.end());
  const std::size_t per_bin =
      std::max<std::size_t>(5, rows.size() / static_cast<std::size_t>(std::max(1, bins)));
  double total = 0.0, square = 0.0;
  for (const auto& [xi, yi] : rows) total += yi, square += yi * yi;
  const double grand = total / static_cast<double>(rows.size());
  double between = 0.0;
  for (std::size_t start = 0; start < rows.size();) {
    std::size_t end = std::min(rows.size(), start + per_bin);
    if (rows.size() - end < per_bin / 2 + 1) end = rows.size();
    // equal x values stay in one bin: a quantised regressor has no order inside a level
    while (end < rows.size() && rows[end].first == rows[end - 1].first) ++end;
    const auto n = static_cast<double>(end - start);
    double sx = 0, sy = 0, syy = 0;
    for (std::size_t i = start; i < end; ++i)
      sx += rows[i].first, sy += rows[i].second, syy += rows[i].second * rows[i].second;
    const double m = sy / n, variance = std::max(0.0, syy / n - m * m);
    curve.points.push_back(
        {sx / n, m, std::sqrt(variance * std::max(1.0, dependence) / n), static_cast<int>(n)});
    between += n * (m - grand) * (m - grand);
    start = end;
  }
  const double variance_total = square - grand * total;
  curve.explained = variance_total > 0.0 ? between / variance_total : 0.0;
  return curve;
}

namespace {

/// The four cubic B-spline weights at fraction u of a segment (uniform knots).
std::array<double, 4> cubic_weights(double u) {
  const double v = 1.0 - u;
  return {v * v * v / 6.0, (3 * u * u * u - 6 * u * u + 4) / 6.0,
          (3 * v * v * v - 6 * v * v + 4) / 6.0, u * u * u / 6.0};
}

struct Knots {
  double low, step;
  int segments;
  std::pair<int, double> locate(double x) const {
    const double s = std::clamp((x - low) / step, 0.0, static_cast<double>(segments));
    const int k = std::min(static_cast<int>(s), segments - 1);
    return {k, s - k};
  }
};

}  // namespace

std::vector<double> smooth_curve(std::span<const double> x, std::span<const double> y,
                                 std::span<const double> at, int segments) {
  std::vector<double> out(at.size(), 0.0);
  const double low = quantile(x, 0.0), high = quantile(x, 1.0);
  if (!(high > low)) return std::vector<double>(at.size(), mean(y));
  const Knots knots{low, (high - low) / segments, segments};
  const int m = segments + 3;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(m, m);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(m);
  double n = 0, yy = 0;
  for (std::size_t i = 0; i < std::min(x.size(), y.size()); ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) continue;
    const auto [k, u] = knots.locate(x[i]);
    const auto w = cubic_weights(u);
    for (int a = 0; a < 4; ++a) {
      right[k + a] += w[static_cast<std::size_t>(a)] * y[i];
      for (int b = 0; b < 4; ++b)
        normal(k + a, k + b) += w[static_cast<std::size_t>(a)] * w[static_cast<std::size_t>(b)];
    }
    n += 1, yy += y[i] * y[i];
  }
  // second differences: what the penalty keeps small
  Eigen::MatrixXd second = Eigen::MatrixXd::Zero(m - 2, m);
  for (int i = 0; i < m - 2; ++i) second(i, i) = 1, second(i, i + 1) = -2, second(i, i + 2) = 1;
  const Eigen::MatrixXd penalty = second.transpose() * second;
  double best = INFINITY;
  Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(m);
  for (double lambda = 1e-3; lambda < 1e6; lambda *= 10) {
    const Eigen::LDLT<Eigen::MatrixXd> factor(normal + lambda * penalty +
                                              1e-9 * Eigen::MatrixXd::Identity(m, m));
    const Eigen::VectorXd c = factor.solve(right);
    const double freedom = factor.solve(normal).trace();
    const double error = yy - 2 * c.dot(right) + c.dot(normal * c);
    const double score = error / std::pow(std::max(1.0, n - freedom), 2);
    if (score < best) best = score, coefficients = c;
  }
  for (std::size_t i = 0; i < at.size(); ++i) {
    const auto [k, u] = knots.locate(at[i]);
    const auto w = cubic_weights(u);
    for (int a = 0; a < 4; ++a) out[i] += w[static_cast<std::size_t>(a)] * coefficients[k + a];
  }
  return out;
}

}  // namespace sanso::diagnose
