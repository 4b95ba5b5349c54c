// Sums over lags directly, without a transform.
#include "tools/diagnose/stats/series.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {

std::vector<double> autocorrelation(std::span<const double> x, std::size_t max_lag) {
  const double centre = mean(x);
  std::vector<double> rho(max_lag + 1, 0.0);
  double power = 0.0;
  for (double v : x) power += (v - centre) * (v - centre);
  if (power <= 0.0) return rho;
  for (std::size_t lag = 0; lag <= max_lag && lag < x.size(); ++lag) {
    double sum = 0.0;
    for (std::size_t i = lag; i < x.size(); ++i) sum += (x[i] - centre) * (x[i - lag] - centre);
    rho[lag] = sum / power;
  }
  return rho;
}

double autocorrelation_time(std::span<const double> x) {
  if (x.size() < 8) return 1.0;
  const std::size_t max_lag = std::min<std::size_t>(x.size() / 4, 400);
  const std::vector<double> rho = autocorrelation(x, max_lag);
  double sum = 0.0;
  for (std::size_t k = 1; k + 1 < rho.size(); k += 2) {
    const double pair = rho[k] + rho[k + 1];
    if (pair <= 0.0) break;
    sum += pair;
  }
  return 1.0 + 2.0 * sum;
}

Autoregression fit_autoregression(std::span<const double> x, std::size_t order) {
  Autoregression model;
  const std::size_t n = x.size();
  const double centre = mean(x);
  std::vector<double> forward(n), backward(n);
  double power = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    forward[i] = backward[i] = x[i] - centre;
    power += forward[i] * forward[i];
  }
  double variance = n > 0 ? power / static_cast<double>(n) : 0.0;
  std::vector<double>& a = model.coefficients;
  for (std::size_t m = 1; m <= order && variance > 0.0 && n > m + 1; ++m) {
    double numerator = 0.0, denominator = 0.0;
    for (std::size_t i = m; i < n; ++i) {
      numerator += forward[i] * backward[i - 1];
      denominator += forward[i] * forward[i] + backward[i - 1] * backward[i - 1];
    }
    if (denominator <= 0.0) break;
    const double reflection = 2.0 * numerator / denominator;
    for (std::size_t i = n - 1; i >= m; --i) {
      const double f = forward[i], b = backward[i - 1];
      forward[i] = f - reflection * b;
      backward[i] = b - reflection * f;
    }
    // Levinson: a_new = a - reflection * reversed(a)
    std::vector<double> previous = a;
    for (std::size_t i = 0; i < previous.size(); ++i)
      a[i] = previous[i] - reflection * previous[previous.size() - 1 - i];
    a.push_back(reflection);
    variance *= 1.0 - reflection * reflection;
  }
  a.resize(order, 0.0);
  model.innovation_sigma = std::sqrt(std::max(variance, 0.0));
  return model;
}

}  // namespace sanso::diagnose
