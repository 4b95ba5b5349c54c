// Did the machine give a program its time? Threads that only sleep see how late they are woken.
#pragma once

#include <pthread.h>
#include <sched.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "shared/base/time.h"

namespace sanso::loop {

/// One sleeper on each processor (on eight at most), from construction to destruction.
class ClockWitness {
 public:
  /// `priority`: of SCHED_FIFO where that is allowed, as the watched program asks for it; 0: an
  /// ordinary program.
  explicit ClockWitness(int priority) {
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) CPU_SET(0, &allowed);
    constexpr std::size_t kMostSleepers = 8;
    for (int cpu = 0; cpu < CPU_SETSIZE && sleepers_.size() < kMostSleepers; ++cpu)
      if (CPU_ISSET(cpu, &allowed))
        sleepers_.emplace_back([this, cpu, priority] { sleep_on(cpu, priority); });
  }
  ~ClockWitness() {
    stop_ = true;
    for (std::thread& sleeper : sleepers_) sleeper.join();
  }
  ClockWitness(const ClockWitness&) = delete;
  ClockWitness& operator=(const ClockWitness&) = delete;

  /// The latest wake-up so far.
  Nanoseconds worst() const { return worst_; }

 private:
  static Nanoseconds now() {
    timespec t{};
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * kSecond + t.tv_nsec;
  }
  void sleep_on(int cpu, int priority) {
    cpu_set_t here;
    CPU_ZERO(&here);
    CPU_SET(static_cast<unsigned>(cpu), &here);
    (void)pthread_setaffinity_np(pthread_self(), sizeof here, &here);
    sched_param parameters{};
    parameters.sched_priority = priority;
    if (priority > 0) (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
    while (!stop_) {
      constexpr Nanoseconds kNap = 2 * kMillisecond;
      const Nanoseconds due = now() + kNap;
      const timespec until{due / kSecond, due % kSecond};
      clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
      const Nanoseconds late = now() - due;
      for (Nanoseconds seen = worst_; late > seen && !worst_.compare_exchange_weak(seen, late);) {
      }
    }
  }

  std::atomic<bool> stop_{false};
  std::atomic<Nanoseconds> worst_{0};
  std::vector<std::thread> sleepers_;
};

}  // namespace sanso::loop
