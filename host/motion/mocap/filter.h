// Small signal tools of the retargeting: zero-phase low-pass, running median and minimum, cubic
// sampling.
#pragma once

#include <vector>

namespace sanso::motion {

/// Second-order Butterworth at `cutoff_Hz`, run forwards and backwards (no delay). The ends are
/// reflected about their first and last value, so that a motion that starts at rest keeps its
/// start.
std::vector<double> low_pass(const std::vector<double>& signal, double dt_s, double cutoff_Hz);

/// Value at a fractional index by a Catmull-Rom cubic; held beyond the ends.
double sample_at(const std::vector<double>& signal, double index);

/// Median and minimum over 2 half + 1 samples, fewer at the ends.
std::vector<double> running_median(const std::vector<double>& signal, int half);
std::vector<double> running_minimum(const std::vector<double>& signal, int half);

/// Value below which `fraction` of the samples lie.
double percentile(std::vector<double> values, double fraction);

}  // namespace sanso::motion
