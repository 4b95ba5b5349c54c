// Properties of a time series: autocorrelation, autoregressive colour, change points.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace sanso::diagnose {

/// Autocorrelation of x at lags 0 .. max_lag (biased estimate, so the sequence is positive
/// definite).
std::vector<double> autocorrelation(std::span<const double> x, int max_lag);

/// Integrated autocorrelation time 1 + 2 sum rho_k, in samples; the sum ends at the first pair
/// rho_2m + rho_2m+1 that is not positive (initial positive sequence, Geyer 1992). At least 1. n /
/// time is the number of independent samples.
double autocorrelation_time(std::span<const double> x);

/// Autoregressive model x_k = sum a_i x_{k-i} + e_k, fitted by Burg's recursion (always stable).
struct Autoregression {
  std::vector<double> coefficients;  // a_1 .. a_p
  double innovation_sigma = 0.0;     // standard deviation of e
};
Autoregression fit_autoregression(std::span<const double> x, int order);

/// Ljung-Box statistic over lags 1 .. lags; chi-square with `lags` degrees of freedom for white x.
double ljung_box(std::span<const double> x, int lags);

/// Change points of the mean: the exact minimum of squared error + penalty per change (PELT,
/// Killick et al. 2012).
/// Returns the first index of every segment after the first. `penalty` in units of x^2; 3 sigma^2
/// log n is the usual choice.
std::vector<std::size_t> change_points(std::span<const double> x, double penalty,
                                       std::size_t minimum_length = 4);

}  // namespace sanso::diagnose
