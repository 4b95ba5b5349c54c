// The k-th smallest of several values, and the three meanings of "quantile" that stand on it. Each
// user keeps its own, since recorded figures and verdicts hang on the last bit. No heap: the values
// are reordered in place.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

namespace sanso::math {

/// The value of rank k (0 = smallest) of `values`, which are partly sorted: smaller ones before it,
/// larger ones behind it. Needs k < values.size().
template <class T>
T value_of_rank(std::span<T> values, std::size_t k) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(k);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Quantile p in [0, 1], linear between the two neighbouring ranks (type 7 of Hyndman and Fan
/// 1996). Needs at least one value.
inline double quantile_linear(std::span<double> values, double p) {
  const double rank = std::clamp(p, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(rank);
  const double at_low = value_of_rank(values, low);
  const double weight = rank - static_cast<double>(low);
  if (weight == 0.0) return at_low;
  const auto above = values.subspan(low + 1);
  return at_low + weight * (*std::min_element(above.begin(), above.end()) - at_low);
}

/// The value at the rank below the quantile: never more than the share p lies below it. Needs at
/// least one value and p in [0, 1].
template <class T>
T quantile_below(std::span<T> values, double p) {
  return value_of_rank(values,
                       static_cast<std::size_t>(p * static_cast<double>(values.size() - 1)));
}

/// Nearest rank (type 1): the smallest value that at least the share p does not exceed, so that the
/// 0.99 of a hundred times is one that happened. Needs at least one value.
template <class T>
T quantile_nearest(std::span<T> values, double p) {
  const auto rank = static_cast<std::size_t>(std::ceil(p * static_cast<double>(values.size())));
  return value_of_rank(values, std::clamp<std::size_t>(rank, 1, values.size()) - 1);
}

}  // namespace sanso::math
