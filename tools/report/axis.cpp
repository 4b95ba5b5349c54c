// Steps of 1, 2 or 5 times a power of ten; a range of no width is widened so that it can be
// drawn.
#include "tools/report/axis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace sanso::report {

void Range::include(double value) {
  if (!std::isfinite(value)) return;
  low_ = seen_ ? std::min(low_, value) : value;
  high_ = seen_ ? std::max(high_, value) : value;
  seen_ = true;
}

Range Range::drawable() const {
  Range r = *this;
  if (!seen_) {
    r.include(0.0);
    r.include(1.0);
  } else if (high_ - low_ <= 1e-12 * std::max(std::abs(low_), std::abs(high_)) || high_ == low_) {
    const double half = std::max(0.5 * std::abs(low_), 1e-6);
    r.include(low_ - half);
    r.include(high_ + half);
  }
  return r;
}

double Axis::pixel(double value) const {
  double s = 0.0;
  if (logarithmic) {
    const double floor = std::min(low, high);  // values at or below zero are drawn on the axis
    s = std::log(std::max(value, floor) / low) / std::log(high / low);
  } else {
    s = (value - low) / (high - low);
  }
  return pixel_low + s * (pixel_high - pixel_low);
}

std::vector<double> ticks(double low, double high, int wanted, bool logarithmic) {
  std::vector<double> out;
  if (logarithmic) {
    const int first = static_cast<int>(std::ceil(std::log10(low) - 1e-9));
    const int last = static_cast<int>(std::floor(std::log10(high) + 1e-9));
    for (int e = first; e <= last; ++e) out.push_back(std::pow(10.0, e));
    if (out.size() >= 2) return out;
    out.clear();  // less than a decade: linear ticks read better
  }
  const double rough = (high - low) / std::max(wanted, 1);
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double mantissa = rough / power;
  const double step = power * (mantissa < 1.5   ? 1.0
                               : mantissa < 3.5 ? 2.0
                               : mantissa < 7.5 ? 5.0
                                                : 10.0);
  const auto first = static_cast<long long>(std::ceil(low / step - 1e-9));
  const auto last = static_cast<long long>(std::floor(high / step + 1e-9));
  for (long long i = first; i <= last; ++i) out.push_back(static_cast<double>(i) * step);
  return out;
}

std::string tick_label(double value) {
  return std::abs(value) < 1e-12 ? "0" : fmt::format("{:.4g}", value);
}

}  // namespace sanso::report
