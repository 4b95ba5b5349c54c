// What no robot may do, in scenarios and in long runs alike.
#pragma once

#include "shared/base/time.h"

namespace sanso::campaign {

inline constexpr double kMaxStep_rad = 0.15 + 1e-9;  // of a target in one tick: 15 rad/s
inline constexpr double kLying_rad = 0.9;            // tilt of the trunk from which on it lies
/// A robot that lies has let go of its joints by then.
inline constexpr Nanoseconds kAfterFall = 5 * kSecond;

}  // namespace sanso::campaign
