// Axes of a chart: round tick positions and the map from data to pixels. Shared by all charts;
// knows no markup.
#pragma once

#include <string>
#include <vector>

namespace sanso::report {

/// Smallest and largest finite value seen so far.
class Range {
 public:
  /// Takes `value` in; NaN and infinities are ignored.
  void include(double value);
  bool empty() const { return !seen_; }
  double low() const { return low_; }
  double high() const { return high_; }
  /// Never empty and never of zero width: [0, 1] when nothing was seen, widened when all values are
  /// equal.
  Range drawable() const;

 private:
  bool seen_ = false;
  double low_ = 0.0, high_ = 0.0;
};

struct Axis {
  double low = 0.0, high = 1.0;              // data
  double pixel_low = 0.0, pixel_high = 1.0;  // where `low` and `high` are drawn
  bool logarithmic = false;
  double pixel(double value) const;
};

/// About `wanted` round values (1, 2 or 5 times a power of ten) inside [low, high]; powers of ten
/// when logarithmic.
std::vector<double> ticks(double low, double high, int wanted, bool logarithmic);

/// The shortest plain form of a tick's value.
std::string tick_label(double value);

}  // namespace sanso::report
