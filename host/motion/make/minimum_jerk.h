// The way from rest to rest that a hand goes: least jerk.
#pragma once

#include <algorithm>

namespace sanso::motion {

/// 0 up to u = 0, 1 from u = 1 on; first and second derivative are 0 at both.
inline double minimum_jerk(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * u * (10 - 15 * u + 6 * u * u);
}

}  // namespace sanso::motion
