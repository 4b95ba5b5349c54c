// A crew of threads and the loops that are open in it, the oldest first. A thread without work
// helps the oldest loop that has pieces left; one that waits for the helpers of its own loop helps
// those that were opened after it, because what it waits for may be among them.
#include "shared/files/parallel.h"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <system_error>
#include <vector>

namespace sanso::files::detail {
namespace {

struct Loop {
  const std::size_t count;
  const std::function<void(std::size_t)>& work;
  const StopRequest* const stop;
  std::atomic<std::size_t> next{0};
  int helpers = 0;  // at work on it; under the crew's lock
  std::mutex failure_lock{};
  std::exception_ptr failure{};

  bool stopped() const { return stop != nullptr && stop->requested(); }
  bool has_pieces() const { return next < count && !stopped(); }

  /// Takes pieces until none is left.
  void take_pieces() {
    while (!stopped()) {
      const std::size_t i = next++;
      if (i >= count) return;
      try {
        work(i);
      } catch (...) {
        const std::lock_guard guard(failure_lock);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  }
  void rethrow() const {
    if (failure) std::rethrow_exception(failure);
    if (stopped()) throw Stopped{};
  }
};

class Crew;
/// The crew that this thread works in.
thread_local Crew* own_crew = nullptr;

class Crew {
 public:
  /// The thread that makes it and up to `helpers` more; fewer where the system gives no more.
  explicit Crew(std::size_t helpers) {
    threads_.reserve(helpers);
    own_crew = this;
    try {
      for (std::size_t i = 0; i < helpers; ++i)
        threads_.emplace_back([this] { help_to_the_end(); });
    } catch (const std::system_error&) {
      // what there is does the work
    }
  }
  ~Crew() {
    {
      const std::lock_guard guard(lock_);
      ended_ = true;
    }
    changed_.notify_all();
    own_crew = nullptr;
  }
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  /// Does the loop with whoever has nothing else to do.
  void run(Loop& loop) {
    open(loop);
    loop.take_pieces();
    std::unique_lock held(lock_);
    while (loop.helpers > 0) help_or_wait(held, position(loop) + 1);
    open_.erase(open_.begin() + static_cast<std::ptrdiff_t>(position(loop)));
  }

 private:
  void open(Loop& loop) {
    {
      const std::lock_guard guard(lock_);
      open_.push_back(&loop);
    }
    changed_.notify_all();
  }
  std::size_t position(const Loop& loop) const {
    return static_cast<std::size_t>(std::find(open_.begin(), open_.end(), &loop) - open_.begin());
  }
  /// With the lock held: a piece of work of the loops from `first` on, or a wait for a change.
  void help_or_wait(std::unique_lock<std::mutex>& held, std::size_t first) {
    const auto found = std::find_if(open_.begin() + static_cast<std::ptrdiff_t>(first), open_.end(),
                                    [](const Loop* l) { return l->has_pieces(); });
    if (found == open_.end()) {
      changed_.wait(held);
      return;
    }
    Loop& loop = **found;
    ++loop.helpers;
    held.unlock();
    loop.take_pieces();
    held.lock();
    if (--loop.helpers == 0) changed_.notify_all();
  }
  void help_to_the_end() {
    own_crew = this;
    std::unique_lock held(lock_);
    while (!ended_) help_or_wait(held, 0);
  }

  std::mutex lock_;
  std::condition_variable changed_;
  std::vector<Loop*> open_;
  bool ended_ = false;
  std::vector<std::jthread> threads_;  // last: they use what stands above
};

}  // namespace

void run_loop(std::size_t count, int threads, const std::function<void(std::size_t)>& work,
              const StopRequest* stop) {
  Loop loop{count, work, stop};
  const auto wanted = std::min<std::size_t>(count, static_cast<std::size_t>(std::max(1, threads)));
  if (own_crew == nullptr && (wanted > 1 || threads <= 1)) {
    Crew(wanted > 1 ? wanted - 1 : 0).run(loop);  // of one thread: loops inside it have no more
  } else if (wanted > 1) {
    own_crew->run(loop);
  } else {
    loop.take_pieces();
  }
  loop.rethrow();
}

}  // namespace sanso::files::detail
