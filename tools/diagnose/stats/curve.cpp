// Penalised cubic B-splines on uniform knots.
#include "tools/diagnose/stats/curve.h"

#include <algorithm>
#include <cmath>

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

}  // namespace sanso::diagnose
