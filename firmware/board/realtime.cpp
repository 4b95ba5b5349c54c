// Each call returns a text that says what was refused and how to allow it, empty when all is
// well; the program decides whether to go on.
#include "firmware/board/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace sanso::board {
namespace {

// twice what a tick needs at most: tests/firmware/realtime/stack_bound.py
constexpr std::size_t kTouchedStack_bytes = 256 * 1024;

/// Touches the stack once, so that no tick is the first to need a page of it.
__attribute__((noinline)) void touch_stack() {
  std::array<volatile char, kTouchedStack_bytes> stack;
  for (std::size_t i = 0; i < stack.size(); i += 1024) stack[i] = 0;
}

}  // namespace

std::string lock_memory() {
  touch_stack();
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return {};
  return std::string("memory is not locked (") + std::strerror(errno) +
         "): a page fault may delay a tick; set 'memlock unlimited' in /etc/security/limits.conf";
}

std::string set_realtime_priority(int priority) {
  touch_stack();  // this thread's own
  sched_param param{};
  param.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
  if (error == 0) return {};
  return std::string("no real-time priority (") + std::strerror(error) +
         "): ticks may be late under load; set 'rtprio 99' for this user in "
         "/etc/security/limits.conf";
}

}  // namespace sanso::board
