// The low-pass is of second order and runs forwards, then backwards: nothing is shifted in time.
#include "host/motion/mocap/filter.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "shared/math/order_statistics.h"

namespace sanso::motion {
namespace {

/// Second-order low-pass by the bilinear transform, transposed direct form II, started in the
/// steady state of `first`.
void filter_in_place(std::vector<double>& signal, double dt_s, double cutoff_Hz) {
  const double c = std::tan(M_PI * std::min(cutoff_Hz * dt_s, 0.49));
  const double norm = 1.0 / (1.0 + std::sqrt(2.0) * c + c * c);
  const double b0 = c * c * norm, b1 = 2 * b0, b2 = b0;
  const double a1 = 2 * (c * c - 1) * norm, a2 = (1 - std::sqrt(2.0) * c + c * c) * norm;
  const double first = signal.front();
  double s1 = first * (1 - b0), s2 = first * (b2 - a2);
  for (double& x : signal) {
    const double y = b0 * x + s1;
    s1 = b1 * x - a1 * y + s2;
    s2 = b2 * x - a2 * y;
    x = y;
  }
}

template <class Pick>
std::vector<double> over_window(const std::vector<double>& signal, int half, Pick&& pick) {
  const int n = static_cast<int>(signal.size());
  std::vector<double> out(signal.size());
  for (int i = 0; i < n; ++i) {
    const int from = std::max(0, i - half), to = std::min(n - 1, i + half);
    out[static_cast<std::size_t>(i)] =
        pick(std::vector<double>(signal.begin() + from, signal.begin() + to + 1));
  }
  return out;
}

}  // namespace

std::vector<double> low_pass(const std::vector<double>& signal, double dt_s, double cutoff_Hz) {
  const auto n = signal.size();
  if (n < 2) return signal;
  // odd reflection: 2 end - value, over a second or what there is
  const auto pad = std::min(n - 1, static_cast<std::size_t>(1.0 / dt_s));
  std::vector<double> padded;
  for (std::size_t k = pad; k > 0; --k) padded.push_back(2 * signal.front() - signal[k]);
  padded.insert(padded.end(), signal.begin(), signal.end());
  for (std::size_t k = 1; k <= pad; ++k) padded.push_back(2 * signal.back() - signal[n - 1 - k]);
  for (int pass = 0; pass < 2; ++pass) {
    filter_in_place(padded, dt_s, cutoff_Hz);
    std::reverse(padded.begin(), padded.end());
  }
  return {padded.begin() + static_cast<std::ptrdiff_t>(pad),
          padded.begin() + static_cast<std::ptrdiff_t>(pad + n)};
}

double sample_at(const std::vector<double>& signal, double index) {
  const auto last = static_cast<double>(signal.size() - 1);
  const double clamped = std::clamp(index, 0.0, last);
  const auto i =
      static_cast<std::ptrdiff_t>(std::min(std::floor(clamped), std::max(last - 1, 0.0)));
  const double t = clamped - static_cast<double>(i);
  const auto at = [&](std::ptrdiff_t k) {
    return signal[static_cast<std::size_t>(
        std::clamp<std::ptrdiff_t>(k, 0, static_cast<std::ptrdiff_t>(last)))];
  };
  const double p0 = at(i - 1), p1 = at(i), p2 = at(i + 1), p3 = at(i + 2);
  return p1 +
         0.5 * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)));
}

std::vector<double> running_median(const std::vector<double>& signal, int half) {
  return over_window(signal, half, [](std::vector<double> window) {
    return math::value_of_rank(std::span(window), window.size() / 2);
  });
}

std::vector<double> running_minimum(const std::vector<double>& signal, int half) {
  return over_window(signal, half, [](const std::vector<double>& window) {
    return *std::min_element(window.begin(), window.end());
  });
}

double percentile(std::vector<double> values, double fraction) {
  return math::quantile_below(std::span(values), fraction);
}

}  // namespace sanso::motion
