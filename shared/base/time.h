// Time as the controller counts it: integer nanoseconds since the controller's boot. Never
// wall-clock time.
#pragma once

#include <cstdint>

namespace sanso {

/// A point in time or a duration, in nanoseconds. Plain integer, so that it is exact on the wire
/// and in tests.
using Nanoseconds = std::int64_t;

inline constexpr Nanoseconds kMicrosecond = 1'000;
inline constexpr Nanoseconds kMillisecond = 1'000'000;
inline constexpr Nanoseconds kSecond = 1'000'000'000;

/// To s, rounded to a double; from s, rounded to the nearest nanosecond.
constexpr double to_seconds(Nanoseconds t) { return static_cast<double>(t) * 1e-9; }
constexpr Nanoseconds from_seconds(double s) {
  return static_cast<Nanoseconds>(s * 1e9 + (s < 0 ? -0.5 : 0.5));
}

// The periods of the three layers (paper, "Learning details"): one place for each number.
// lower layer, low-level controller
inline constexpr Nanoseconds kTickPeriod = 10 * kMillisecond;
inline constexpr double kTick_s = to_seconds(kTickPeriod);
inline constexpr Nanoseconds kMiddlePeriod = 30 * kMillisecond;  // middle layer's grid
inline constexpr int kTicksPerMiddle = 3;
inline constexpr int kTicksPerUpper = 6;

}  // namespace sanso
