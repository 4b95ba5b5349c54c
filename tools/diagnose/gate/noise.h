// Noise of a channel: quantisation step, standard deviation, colour.
#pragma once

#include <span>

#include "tools/diagnose/gate/gate.h"

namespace sanso::diagnose {

/// Quantisation step: the largest step of which at least 95 % of all differences are multiples; 0
/// when there is none coarser than the number format (1e-6 of the range).
double quantisation_step(std::span<const double> x);

/// Rows of the calmest quarter of windows (whose means move least) among those in which x changes
/// at all, as [first, last) pairs: standstill if there is any.
std::vector<std::pair<std::size_t, std::size_t>> calm_windows(std::span<const double> x,
                                                              std::size_t window);

/// Standard deviation from second differences in calm windows (var = 6 sigma^2), never below
/// quantum / sqrt(12).
NoiseLevel noise_level(const std::string& channel, std::span<const double> x,
                       const GateSettings& settings);

}  // namespace sanso::diagnose
