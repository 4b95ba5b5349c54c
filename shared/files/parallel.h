// Runs independent pieces of work on several threads; which thread does which piece never shows in
// the result, as long as every piece writes its own place.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <thread>

namespace sanso::files {

/// Asks loops to end at the next piece. request() is safe inside a signal handler.
class StopRequest {
 public:
  void request() { requested_.store(true); }
  bool requested() const { return requested_.load(); }

 private:
  std::atomic<bool> requested_{false};
  static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");
};

/// Thrown by a loop that a StopRequest ended: some pieces were not done.
struct Stopped {};

/// One a core; 1 where the machine does not say.
inline int all_cores() {
  return static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

namespace detail {
void run_loop(std::size_t count, int threads, const std::function<void(std::size_t)>& work,
              const StopRequest* stop);
}  // namespace detail

/// Calls work(i) for i in [0, count), each once, on up to `threads` threads, and waits. A loop
/// inside a piece starts no threads: those of the loop outside help it when they have nothing else
/// to do. A thread that waits for its inner loop may therefore do another loop's piece meanwhile:
/// `work` holds no lock and no thread_local state over an inner loop. The first exception ends the
/// loop and is rethrown when all threads have ended; throws Stopped when `stop` was requested.
template <class Work>
void parallel_for(std::size_t count, int threads, const Work& work,
                  const StopRequest* stop = nullptr) {
  detail::run_loop(count, threads, std::cref(work), stop);
}

}  // namespace sanso::files
