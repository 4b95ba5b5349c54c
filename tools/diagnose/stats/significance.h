// From statistics to decisions: tail probabilities, many tests at once, resampling of dependent
// data.
#pragma once

#include <functional>
#include <numeric>
#include <span>
#include <vector>

#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {

inline constexpr double kNormal95 = 1.96;  // half-width of 95 % of a normal, standard errors

/// P(Z > z) of the standard normal.
double normal_tail(double z);
/// The z that a standard normal exceeds with probability `p` in (0, 0.5].
double normal_score(double p);
/// P(X > x) of chi-square with k degrees of freedom (Wilson and Hilferty 1931; relative error below
/// 2 % for k >= 3).
double chi_square_tail(double x, double k);
/// P(X >= k) of n draws with probability `share` each; 0 <= k <= n.
double binomial_tail(double k, double n, double share);

/// Benjamini-Hochberg: adjusted p-values (q-values), same order as `p`.
std::vector<double> false_discovery_rate(std::span<const double> p);

/// Family-wise p by step-down max-T (Westfall and Young 1993, algorithm 4.1). `null_draw(b, out)`
/// fills one joint draw of all statistics under the null. Large statistic = evidence. Result[i] >=
/// 1 / (draws + 1).
std::vector<double> step_down_max_t(std::span<const double> statistic, int draws,
                                    const std::function<void(int, std::span<double>)>& null_draw);

/// In the order of x.
inline double sum(const std::vector<double>& x) { return std::accumulate(x.begin(), x.end(), 0.0); }

/// Interval [low, high] of a statistic.
struct Interval {
  double low = 0.0;
  double high = 0.0;
};

/// Lower confidence bound (one-sided, `level`) of the sum of `x`, whose neighbours may depend:
/// moving-block bootstrap (Kuensch 1989), blocks of n^(1/3) entries or three autocorrelation times
/// (a third of all at most), percentiles widened by sqrt(n / (n - block)) since fewer blocks spread
/// too little. The sum itself for n < 2.
double moving_block_lower_bound(std::span<const double> x, double level, int draws, Random random);
/// The same of several series by each other, resampled within each: what differs between them is no
/// chance.
double stratified_lower_bound(std::span<const std::vector<double>> strata, double level, int draws,
                              Random random);

/// Wilson interval (95 %) of a proportion: `successes` of `trials`.
Interval wilson_interval(int successes, int trials);

}  // namespace sanso::diagnose
