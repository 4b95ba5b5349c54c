// Order statistics and robust scale. Inputs may hold NaN (not sampled); NaN is left out.
#pragma once

#include <span>
#include <vector>

namespace sanso::diagnose {

/// The finite values of x, in order.
std::vector<double> finite_values(std::span<const double> x);

/// Quantile p in [0, 1] with linear interpolation; NaN when there is no finite value.
double quantile(std::span<const double> x, double p);
/// Of the finite values; NaN when there are none.
double median(std::span<const double> x);

inline constexpr double kSigmaOfMedian = 1.4826;  // sigma of a normal over the median of |x|

/// Standard deviation by the median absolute deviation (times 1.4826, exact for normal data).
double robust_sigma(std::span<const double> x);

/// Of the finite values; 0 when there are none.
double mean(std::span<const double> x);
/// Of the finite values, over n - 1; 0 when there are fewer than two.
double standard_deviation(std::span<const double> x);

/// Root mean square of the finite values; 0 when there are none.
double rms(std::span<const double> x);

/// Pearson correlation over the rows where both are finite; 0 when a side is constant or fewer than
/// 3 rows remain.
double correlation(std::span<const double> x, std::span<const double> y);

}  // namespace sanso::diagnose
