#include "tools/diagnose/compare/parallel.h"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace sanso::diagnose {
namespace {

std::atomic<bool> stop{false};
/// True on threads that work for a parallel_for already: loops inside it run one after the other.
thread_local bool inside = false;
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

}  // namespace

void request_stop() { stop.store(true); }
bool stop_requested() { return stop.load(); }

void parallel_for(int count, const std::function<void(int)>& task) {
  std::atomic<int> next{0};
  std::exception_ptr failure;
  std::mutex guard;
  const auto work = [&] {
    const bool outer = std::exchange(inside, true);
    for (int i = next++; i < count && !stop_requested(); i = next++) {
      try {
        task(i);
      } catch (...) {
        const std::lock_guard lock(guard);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
    inside = outer;
  };
  const int cores =
      inside ? 1 : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const int threads = std::min(count, cores);
  std::vector<std::thread> pool;
  for (int i = 1; i < threads; ++i) pool.emplace_back(work);
  work();
  for (std::thread& t : pool) t.join();
  if (failure) std::rethrow_exception(failure);
  if (stop_requested()) throw Interrupted{};
}

}  // namespace sanso::diagnose
