// Properties of a time series: autocorrelation, autoregressive colour.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace sanso::diagnose {

/// Autocorrelation of x at lags 0 .. max_lag (biased estimate, so the sequence is positive
/// definite).
std::vector<double> autocorrelation(std::span<const double> x, std::size_t max_lag);

/// Integrated autocorrelation time 1 + 2 sum rho_k, in samples; the sum ends at the first pair
/// rho_2m + rho_2m+1 that is not positive (initial positive sequence, Geyer 1992). At least 1. n /
/// time is the number of independent samples.
double autocorrelation_time(std::span<const double> x);

/// Autoregressive model x_k = sum a_i x_{k-i} + e_k, fitted by Burg's recursion (always stable).
struct Autoregression {
  std::vector<double> coefficients;  // a_1 .. a_p
  double innovation_sigma = 0.0;     // standard deviation of e
};
/// Of x less its mean; where x is too short, or nothing is left of it, the last ones are zero.
Autoregression fit_autoregression(std::span<const double> x, std::size_t order);

}  // namespace sanso::diagnose
