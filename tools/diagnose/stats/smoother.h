// Smoothed position, velocity and acceleration of one joint from its (uneven, noisy) position
// samples.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "tools/diagnose/settings_of_data.h"

namespace sanso::diagnose {

struct SmoothedState {
  std::vector<double> q;         // position                        rad (or m)
  std::vector<double> dq;        // velocity                        rad/s
  std::vector<double> ddq;       // acceleration                    rad/s^2
  std::vector<double> q_sigma;   // standard deviation of q         rad
  std::vector<double> dq_sigma;  // standard deviation of dq        rad/s
  double jerk_density = 0.0;     // spectral density of the jerk that was used     rad^2/s^5
};

/// Rauch-Tung-Striebel smoother of the constant-jerk (white-jerk) model; state [q, dq, ddq], exact
/// for uneven sampling.
/// The jerk density is the one of largest likelihood of the first `likelihood_rows` rows on a
/// logarithmic grid. An empty (NaN) q is a
/// row without measurement. `t` [s] strictly increasing, at least 3 finite q; `sigma` > 0 is the
/// standard deviation of a position sample [rad].
SmoothedState smooth_position(std::span<const double> t, std::span<const double> q, double sigma,
                              const SmootherSettings& before = {},
                              int likelihood_rows = std::numeric_limits<int>::max());
/// The same with a deviation for every sample.
SmoothedState smooth_position(std::span<const double> t, std::span<const double> q,
                              std::span<const double> sigma, const SmootherSettings& before = {},
                              int likelihood_rows = std::numeric_limits<int>::max());

}  // namespace sanso::diagnose
