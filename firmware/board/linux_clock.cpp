// CLOCK_MONOTONIC and the thread's processor time; sleeping goes on after a signal until the
// given instant.
#include "firmware/board/linux_clock.h"

#include <poll.h>
#include <cerrno>
#include <ctime>

namespace sanso::board {
namespace {

Nanoseconds read_clock(clockid_t id) {
  timespec t{};
  clock_gettime(id, &t);
  return static_cast<Nanoseconds>(t.tv_sec) * kSecond + t.tv_nsec;
}

timespec to_timespec(Nanoseconds t) {
  return {static_cast<time_t>(t / kSecond), static_cast<long>(t % kSecond)};
}

}  // namespace

Nanoseconds LinuxClock::now() { return read_clock(CLOCK_MONOTONIC); }
Nanoseconds LinuxClock::thread_cpu() { return read_clock(CLOCK_THREAD_CPUTIME_ID); }

void LinuxClock::sleep_until(Nanoseconds time) {
  const timespec t = to_timespec(time);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

int wait_readable(int descriptor, Nanoseconds deadline) {
  for (;;) {
    const Nanoseconds left = deadline - read_clock(CLOCK_MONOTONIC);
    const timespec wait = to_timespec(left > 0 ? left : 0);
    pollfd p{descriptor, POLLIN, 0};
    const int n = ppoll(&p, 1, &wait, nullptr);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return -1;
    if (n == 0) return 0;
    return (p.revents & POLLIN) != 0 ? 1 : -1;
  }
}

}  // namespace sanso::board
