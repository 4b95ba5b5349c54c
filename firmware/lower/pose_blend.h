// Minimum-jerk passage from one pose to another: rests at both ends, no step in velocity or
// acceleration.
#pragma once

#include <algorithm>
#include <cmath>

#include "shared/base/time.h"
#include "shared/model/state_layout.h"

namespace sanso::firmware {

/// s(0) = 0, s(1) = 1, first and second derivative 0 at both ends.   [Flash & Hogan 1985]
constexpr double minimum_jerk(double t) {
  const double u = t < 0 ? 0 : (t > 1 ? 1 : t);
  return u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
}

/// A passage that began at `from`; its goal may move while it is under way.
class PoseBlend {
 public:
  /// Begins anew at `from` [rad]; the passage takes `duration_s`, at least one tick.
  void start(const model::Input& from, double duration_s) {
    from_ = from;
    tick_ = 0;
    ticks_ = std::max(1, static_cast<int>(std::lround(duration_s / to_seconds(kTickPeriod))));
  }
  /// Next pose on the way to `goal`; equals `goal` once done().
  model::Input step(const model::Input& goal) {
    tick_ = std::min(tick_ + 1, ticks_);
    return from_ + fraction() * (goal - from_);
  }
  /// Of the way, 0 to 1.
  double fraction() const { return minimum_jerk(static_cast<double>(tick_) / ticks_); }
  bool done() const { return tick_ >= ticks_; }

 private:
  model::Input from_ = model::Input::Zero();
  int tick_ = 1;
  int ticks_ = 1;
};

}  // namespace sanso::firmware
