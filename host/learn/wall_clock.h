// Wall time, for what a run says of its own cost: never a part of an answer.
#pragma once

#include <chrono>

namespace sanso::learn {

/// Seconds of a clock that only goes forward, since some instant.
inline double wall_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace sanso::learn
