// Runs independent pieces of work on several threads; which thread does which piece never shows in
// the result, as long as every piece writes its own place.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

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
/// True on threads that work for a parallel_for already.
inline thread_local bool inside_parallel_for = false;
}  // namespace detail

/// Calls work(i) for i in [0, count), each once, on up to `threads` threads, and waits. A loop
/// inside a piece runs on its own thread alone. The first exception ends the loop and is rethrown
/// when all threads have ended; throws Stopped when `stop` was requested.
template <class Work>
void parallel_for(std::size_t count, int threads, const Work& work,
                  const StopRequest* stop = nullptr) {
  const auto wanted = detail::inside_parallel_for ? 1 : std::max(1, threads);
  const auto workers = std::min<std::size_t>(count, static_cast<std::size_t>(wanted));
  const auto stopped = [&] { return stop != nullptr && stop->requested(); };
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_lock;
  const auto run = [&] {
    const bool outer = std::exchange(detail::inside_parallel_for, true);
    for (std::size_t i = next++; i < count && !stopped(); i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::lock_guard guard(failure_lock);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
    detail::inside_parallel_for = outer;
  };
  std::vector<std::jthread> pool;
  for (std::size_t t = 1; t < workers; ++t) pool.emplace_back(run);
  run();
  pool.clear();
  if (failure) std::rethrow_exception(failure);
  if (stopped()) throw Stopped{};
}

}  // namespace sanso::files
