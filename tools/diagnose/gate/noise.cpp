// The step of the grid comes first: the largest one on which nearly all values lie.
#include "tools/diagnose/gate/noise.h"

#include <algorithm>
#include <cmath>

#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/series.h"

namespace sanso::diagnose {

double quantisation_step(std::span<const double> x) {
  const std::vector<double> v = finite_values(x);
  if (v.size() < 20) return 0.0;
  const auto [low, high] = std::minmax_element(v.begin(), v.end());
  // differences below this are rounding of the number format
  const double resolution = 1e-6 * (*high - *low);
  if (resolution <= 0.0) return 0.0;
  std::vector<double> steps;
  for (std::size_t i = 1; i < v.size(); ++i) {
    const double d = std::abs(v[i] - v[i - 1]);
    if (d > resolution) steps.push_back(d);
  }
  if (steps.size() < 10) return 0.0;
  double step = quantile(steps, 0.02);
  // two refinements: multiples seen at larger distance fix the step more precisely
  for (int pass = 0; pass < 2; ++pass) {
    double numerator = 0.0, denominator = 0.0;
    for (double d : steps) {
      const double k = std::round(d / step);
      if (k < 1 || k > 20) continue;
      numerator += k * d, denominator += k * k;
    }
    if (denominator > 0.0) step = numerator / denominator;
  }
  std::size_t multiples = 0, considered = 0;
  for (double d : steps) {
    if (d > 40 * step) continue;  // the step's own error grows with the multiple
    ++considered;
    if (std::abs(d / step - std::round(d / step)) < 0.08) ++multiples;
  }
  return static_cast<double>(multiples) >=
                 0.95 * static_cast<double>(std::max<std::size_t>(considered, 1))
             ? step
             : 0.0;
}

namespace {

/// How far the means of a window's quarters go. Not how far its samples do: where noise chooses the
/// windows, those that it left quiet by chance are chosen, and their noise is measured too small.
double motion_in(std::span<const double> x) {
  const std::size_t length = std::max<std::size_t>(1, x.size() / 4);
  double travel = 0.0, previous = NAN;
  for (std::size_t start = 0; start + length <= x.size(); start += length) {
    const double here = mean(x.subspan(start, length));
    if (std::isfinite(previous)) travel += std::abs(here - previous);
    previous = here;
  }
  return travel;
}

/// Whether a window shows noise at all: a reading that never changes is held or too coarse.
bool changes(std::span<const double> x) {
  return std::any_of(x.begin(), x.end(), [&](double value) { return value != x.front(); });
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> calm_windows(std::span<const double> x,
                                                              std::size_t window) {
  std::vector<std::pair<std::size_t, std::size_t>> windows;
  std::vector<double> motion;
  for (std::size_t start = 0; start + window <= x.size(); start += window) {
    if (!changes(x.subspan(start, window))) continue;
    windows.emplace_back(start, start + window);
    motion.push_back(motion_in(x.subspan(start, window)));
  }
  std::vector<std::pair<std::size_t, std::size_t>> out;
  const double limit = quantile(motion, 0.25);
  for (std::size_t w = 0; w < motion.size(); ++w) {
    if (motion[w] <= limit) out.push_back(windows[w]);
  }
  return out;
}

NoiseLevel noise_level(const std::string& channel, std::span<const double> x,
                       const GateSettings& settings) {
  NoiseLevel level;
  level.channel = channel;
  const std::vector<double> v = finite_values(x);
  level.quantum = quantisation_step(v);
  const auto window = static_cast<std::size_t>(settings.calm_rows);
  double sum = 0.0;
  std::size_t count = 0;
  std::vector<double> standstill;
  for (const auto& [first, last] : calm_windows(v, window)) {
    std::vector<double> second;
    for (std::size_t i = first + 1; i + 1 < last; ++i)
      second.push_back(v[i + 1] - 2 * v[i] + v[i - 1]);
    // robust within the window: one glitch must not decide
    const double limit = 6.0 * std::max(robust_sigma(second), level.quantum);
    for (double d : second) {
      if (limit > 0.0 && std::abs(d) > limit) continue;
      sum += d * d, ++count;
    }
    standstill.insert(standstill.end(), v.begin() + static_cast<std::ptrdiff_t>(first),
                      v.begin() + static_cast<std::ptrdiff_t>(last));
  }
  const double from_differences =
      count > 0 ? std::sqrt(sum / (6.0 * static_cast<double>(count))) : 0.0;
  level.sigma = std::max(from_differences, level.quantum / std::sqrt(12.0));
  if (standstill.size() >= 4 * window)
    level.colour = fit_autoregression(standstill, 4).coefficients;
  return level;
}

}  // namespace sanso::diagnose
