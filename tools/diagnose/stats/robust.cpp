// Each figure takes its finite values first and decides what none of them means.
#include "tools/diagnose/stats/robust.h"

#include <cmath>
#include <limits>

#include "shared/math/order_statistics.h"

namespace sanso::diagnose {

std::vector<double> finite_values(std::span<const double> x) {
  std::vector<double> out;
  out.reserve(x.size());
  for (double v : x) {
    if (std::isfinite(v)) out.push_back(v);
  }
  return out;
}

double quantile(std::span<const double> x, double p) {
  std::vector<double> v = finite_values(x);
  if (v.empty()) return std::numeric_limits<double>::quiet_NaN();
  return math::quantile_linear(v, p);
}

double median(std::span<const double> x) { return quantile(x, 0.5); }

double robust_sigma(std::span<const double> x) {
  std::vector<double> v = finite_values(x);
  if (v.empty()) return 0.0;
  const double centre = median(v);
  for (double& value : v) value = std::abs(value - centre);
  return kSigmaOfMedian * median(v);
}

double mean(std::span<const double> x) {
  const std::vector<double> v = finite_values(x);
  if (v.empty()) return 0.0;
  double sum = 0.0;
  for (double value : v) sum += value;
  return sum / static_cast<double>(v.size());
}

double standard_deviation(std::span<const double> x) {
  const std::vector<double> v = finite_values(x);
  if (v.size() < 2) return 0.0;
  const double centre = mean(v);
  double sum = 0.0;
  for (double value : v) sum += (value - centre) * (value - centre);
  return std::sqrt(sum / static_cast<double>(v.size() - 1));
}

double rms(std::span<const double> x) {
  double sum = 0.0;
  std::size_t n = 0;
  for (double value : x) {
    if (!std::isfinite(value)) continue;
    sum += value * value;
    ++n;
  }
  return n == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(n));
}

double correlation(std::span<const double> x, std::span<const double> y) {
  double n = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
  const std::size_t rows = std::min(x.size(), y.size());
  // shifted by the first finite pair, so that a large common offset costs no digits
  double x0 = 0, y0 = 0;
  for (std::size_t i = 0; i < rows; ++i) {
    if (!std::isfinite(x[i]) || !std::isfinite(y[i])) continue;
    if (n == 0) x0 = x[i], y0 = y[i];
    const double a = x[i] - x0, b = y[i] - y0;
    n += 1, sx += a, sy += b, sxx += a * a, syy += b * b, sxy += a * b;
  }
  if (n < 3) return 0.0;
  const double vx = sxx - sx * sx / n, vy = syy - sy * sy / n;
  if (vx <= 0.0 || vy <= 0.0) return 0.0;
  return (sxy - sx * sy / n) / std::sqrt(vx * vy);
}

}  // namespace sanso::diagnose
