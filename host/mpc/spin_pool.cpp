// One atomic word holds phase, number of items and next item; a thread claims an item by
// compare-and-swap and therefore never takes one of another phase.
#include "host/mpc/spin_pool.h"

#include <pthread.h>
#include <sched.h>

#include <cassert>

namespace sanso::mpc {
namespace {

constexpr int kFieldBits = 20;
constexpr std::uint64_t kFieldMask = (1u << kFieldBits) - 1;
// After this many empty looks (some tens of microseconds) a waiting thread lets others run: matters
// only when more threads want to run than there are processors.
constexpr int kLooksBeforeYield = 4000;

int items_of(std::uint64_t ticket) { return static_cast<int>((ticket >> kFieldBits) & kFieldMask); }
int next_of(std::uint64_t ticket) { return static_cast<int>(ticket & kFieldMask); }

void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

void bind_to_processor(int processor) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(processor) % static_cast<unsigned>(CPU_SETSIZE), &set);
  // refused when the processor does not exist or is not ours: then the scheduler decides, which is
  // the default anyway
  (void)pthread_setaffinity_np(pthread_self(), sizeof set, &set);
}

}  // namespace

SpinPool::SpinPool(int threads, bool pin) {
  if (pin) bind_to_processor(0);
  for (int i = 1; i < threads; ++i) helpers_.emplace_back([this, i, pin] { helper(i, pin); });
}

SpinPool::~SpinPool() {
  stop_ = true;
  wake();
  for (std::thread& helper : helpers_) helper.join();
}

void SpinPool::wake() {
  awake_.fetch_add(1);
  if (!helpers_.empty()) awake_.notify_all();
}

void SpinPool::sleep() { awake_.fetch_add(1); }

bool SpinPool::work_once(int thread) {
  std::uint64_t seen = ticket_.load(std::memory_order_acquire);
  if (next_of(seen) >= items_of(seen)) return false;
  // a claim: from here until done_ is raised the phase cannot end, so call_ and context_ stay valid
  if (!ticket_.compare_exchange_strong(seen, seen + 1, std::memory_order_acq_rel)) return true;
  call_(context_, next_of(seen), thread);
  done_.fetch_add(1, std::memory_order_release);
  return true;
}

void SpinPool::begin_items(int items, Call call, const void* context) {
  assert(items > 0 && items <= static_cast<int>(kFieldMask));
  call_ = call;
  context_ = context;
  items_ = items;
  done_.store(0, std::memory_order_relaxed);
  const std::uint64_t phase = (ticket_.load(std::memory_order_relaxed) >> (2 * kFieldBits)) + 1;
  ticket_.store(phase << (2 * kFieldBits) | static_cast<std::uint64_t>(items) << kFieldBits,
                std::memory_order_release);
}

void SpinPool::finish() {
  while (work_once(0)) {
  }
  for (int looks = 0; done_.load(std::memory_order_acquire) < items_; ++looks) {
    if (looks > kLooksBeforeYield) sched_yield();
    pause();
  }
}

void SpinPool::helper(int thread, bool pin) {
  if (pin) bind_to_processor(thread);
  std::uint32_t seen = 0;
  while (!stop_) {
    awake_.wait(seen);  // sleeps while no session is open (even count)
    seen = awake_.load();
    for (int looks = 0; (seen & 1u) != 0 && !stop_; seen = awake_.load()) {
      if (work_once(thread)) {
        looks = 0;
      } else if (++looks > kLooksBeforeYield) {
        sched_yield();
      } else {
        pause();
      }
    }
  }
}

}  // namespace sanso::mpc
