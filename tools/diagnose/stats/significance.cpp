// Corrections for many tests by sorting; resampling by moving blocks, so that dependence inside
// a block survives.
#include "tools/diagnose/stats/significance.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/series.h"

namespace sanso::diagnose {

double normal_tail(double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); }

double normal_score(double p) {
  double low = 0.0, high = 40.0;
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = 0.5 * (low + high);
    (normal_tail(middle) > p ? low : high) = middle;
  }
  return low;
}

double chi_square_tail(double x, double k) {
  if (x <= 0.0) return 1.0;
  const double spread = 2.0 / (9.0 * k);
  return normal_tail((std::cbrt(x / k) - (1.0 - spread)) / std::sqrt(spread));
}

double binomial_tail(double k, double n, double share) {
  if (k <= 0.0) return 1.0;
  if (share <= 0.0 || share >= 1.0) return share >= 1.0 ? 1.0 : 0.0;
  double sum = 0.0;
  for (double i = k; i <= n; i += 1.0) {
    sum += std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0) +
                    i * std::log(share) + (n - i) * std::log1p(-share));
  }
  return std::min(1.0, sum);
}

namespace {

std::vector<std::size_t> order_of(std::span<const double> x, bool descending) {
  std::vector<std::size_t> order(x.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return descending ? x[a] > x[b] : x[a] < x[b];
  });
  return order;
}

}  // namespace

std::vector<double> false_discovery_rate(std::span<const double> p) {
  const std::vector<std::size_t> order = order_of(p, false);
  std::vector<double> q(p.size(), 1.0);
  double smallest = 1.0;
  for (std::size_t rank = p.size(); rank-- > 0;) {
    const double scaled =
        p[order[rank]] * static_cast<double>(p.size()) / static_cast<double>(rank + 1);
    smallest = std::min(smallest, scaled);
    q[order[rank]] = smallest;
  }
  return q;
}

std::vector<double> step_down_max_t(std::span<const double> statistic, int draws,
                                    const std::function<void(int, std::span<double>)>& null_draw) {
  const std::size_t n = statistic.size();
  const std::vector<std::size_t> order = order_of(statistic, true);
  std::vector<int> exceed(n, 0);
  std::vector<double> draw(n);
  for (int b = 0; b < draws; ++b) {
    null_draw(b, draw);
    // maximum over the hypotheses not yet rejected when rank i is tested
    double running = -INFINITY;
    for (std::size_t rank = n; rank-- > 0;) {
      running = std::max(running, draw[order[rank]]);
      if (running >= statistic[order[rank]]) ++exceed[rank];
    }
  }
  std::vector<double> p(n, 1.0);
  double largest = 0.0;
  for (std::size_t rank = 0; rank < n; ++rank) {
    largest = std::max(largest, (exceed[rank] + 1.0) / (draws + 1.0));
    p[order[rank]] = largest;
  }
  return p;
}

namespace {

/// Sums of `draws` resamples less their mean, widened: what chance adds to the sum of `x`.
std::vector<double> moving_block_deviations(std::span<const double> x, int draws, Random& random) {
  std::vector<double> sums(static_cast<std::size_t>(draws), 0.0);
  if (x.size() < 2) return sums;
  const auto n = static_cast<double>(x.size());
  const double wanted = std::max(std::cbrt(n), 3.0 * autocorrelation_time(x));
  const auto block =
      static_cast<std::size_t>(std::clamp(std::ceil(wanted), 1.0, std::max(1.0, n / 3.0)));
  const std::size_t starts = x.size() - block + 1;
  for (double& sum : sums) {
    for (std::size_t taken = 0; taken < x.size();) {
      const std::size_t from = random.below(starts);
      for (std::size_t i = 0; i < block && taken < x.size(); ++i, ++taken) sum += x[from + i];
    }
  }
  // blocks that cannot wrap around reach the ends less often: their mean is taken out, the sum's
  // own put in
  const double widened = std::sqrt(n / (n - static_cast<double>(block)));
  const double centre = mean(sums);
  for (double& sum : sums) sum = widened * (sum - centre);
  return sums;
}

}  // namespace

double moving_block_lower_bound(std::span<const double> x, double level, int draws, Random random) {
  const std::vector<double> of_all(x.begin(), x.end());
  return stratified_lower_bound(std::span(&of_all, 1), level, draws, random);
}

double stratified_lower_bound(std::span<const std::vector<double>> strata, double level, int draws,
                              Random random) {
  double total = 0.0;
  std::vector<double> deviations(static_cast<std::size_t>(draws), 0.0);
  for (const std::vector<double>& x : strata) {
    total += std::accumulate(x.begin(), x.end(), 0.0);
    const std::vector<double> of_one = moving_block_deviations(x, draws, random);
    for (std::size_t b = 0; b < deviations.size(); ++b) deviations[b] += of_one[b];
  }
  return total + quantile(deviations, level);
}

Interval wilson_interval(int successes, int trials) {
  if (trials == 0) return {0.0, 1.0};
  constexpr double z = 1.959964;
  const double n = trials, p = successes / n;
  const double centre = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / (1 + z * z / n);
  return {std::max(0.0, centre - half), std::min(1.0, centre + half)};
}

}  // namespace sanso::diagnose
