// A few threads that share the items of one phase after another. Inside a session (one plan) they
// wait by spinning, so that a phase of 20 us starts within a fraction of a microsecond; between
// sessions they sleep and cost nothing.
// Items are claimed one by one: a helper that the operating system has put aside delays nobody but
// its own item.
// What is computed never depends on which thread does it.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace sanso::mpc {

class SpinPool {
 public:
  /// `threads` counts the caller; threads - 1 helpers start. With `pin`, thread i is bound to
  /// processor i.
  SpinPool(int threads, bool pin);
  ~SpinPool();
  SpinPool(const SpinPool&) = delete;
  SpinPool& operator=(const SpinPool&) = delete;

  int threads() const { return static_cast<int>(helpers_.size()) + 1; }

  /// While an object of this type lives, helpers spin.
  class Session {
   public:
    explicit Session(SpinPool& pool) : pool_(pool) { pool_.wake(); }
    ~Session() { pool_.sleep(); }
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

   private:
    SpinPool& pool_;
  };

  /// Calls task(item, thread) for item 0 .. items - 1, each once, and returns when all are done. No
  /// allocation.
  template <class Task>
  void run(int items, const Task& task) {
    begin(items, task);
    finish();
  }

  /// The same in parts, for a caller with work of its own between: begin() returns at once, help()
  /// does one item that nobody has claimed (false: there is none), finish() the rest. `task` must
  /// live until then.
  template <class Task>
  void begin(int items, const Task& task) {
    begin_items(
        items,
        [](const void* context, int item, int thread) {
          (*static_cast<const Task*>(context))(item, thread);
        },
        &task);
  }
  bool help() { return work_once(0); }
  void finish();

 private:
  using Call = void (*)(const void* context, int item, int thread);
  void begin_items(int items, Call call, const void* context);
  bool work_once(int thread);
  void helper(int thread, bool pin);
  void wake();
  void sleep();

  // One word, so that a claim and what it belongs to cannot come apart: [phase 24 | items 20 | next
  // item 20].
  std::atomic<std::uint64_t> ticket_{0};
  std::atomic<int> done_{0};
  std::atomic<std::uint32_t> awake_{0};  // odd: a session is open
  std::atomic<bool> stop_{false};
  Call call_ = nullptr;  // valid while the phase has unfinished items
  const void* context_ = nullptr;
  int items_ = 0;  // of the phase
  std::vector<std::thread> helpers_;
};

}  // namespace sanso::mpc
