// CLOCK_MONOTONIC, the time base of everything on the robot.
#pragma once

#include "firmware/board/board.h"

namespace sanso::board {

class LinuxClock : public Clock {
 public:
  Nanoseconds now() override;
  Nanoseconds thread_cpu() override;
  /// Sleeps until `time` (absolute: no drift, no race with a late wake-up).
  static void sleep_until(Nanoseconds time);
};

/// Waits until `descriptor` is readable or `deadline` has passed. 1 readable, 0 deadline, -1 error
/// or hang-up.
int wait_readable(int descriptor, Nanoseconds deadline);

}  // namespace sanso::board
