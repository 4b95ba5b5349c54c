// After arming nothing allocates and no page is missed: 10 000 ticks of a trial with all three
// layers.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tools/bench/tick_rig.h"

// GCC says it with a macro, clang 14 with a feature.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kShadowMemory = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
constexpr bool kShadowMemory = true;
#else
constexpr bool kShadowMemory = false;
#endif
#else
constexpr bool kShadowMemory = false;
#endif

namespace {
std::atomic<long> allocations{0};
}

// Counting replacements of the global allocation functions; everything else behaves as usual.
void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const std::size_t a = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(a, (size + a - 1) / a * a)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace sanso {
namespace {

long page_faults() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_minflt + usage.ru_majflt;
}

struct Counted {
  bool started = false;
  long allocations = 0, page_faults = 0;
  wire::SupervisorState state{};
  float upper_weight = 0;
};

Counted count_ten_thousand_ticks() {
  Counted counted;
  const long before_setup = allocations;
  bench::TickRig rig;
  counted.started = allocations > before_setup && rig.start_trial();
  for (int i = 0; i < 600; ++i) rig.tick();  // every page of the tables has been read once
  const long allocated = allocations, missed = page_faults();
  for (int i = 0; i < 10'000; ++i) rig.tick();
  counted.allocations = allocations - allocated;
  counted.page_faults = page_faults() - missed;
  counted.state = rig.controller().state();
  counted.upper_weight = rig.controller().observation().upper_weight;
  return counted;
}

/// The count in a process of its own: every one begins with the same, untouched memory.
Counted count_in_a_fresh_process() {
  int ends[2];
  Counted counted;
  if (pipe(ends) != 0) return counted;
  const pid_t child = fork();
  if (child == 0) {
    counted = count_ten_thousand_ticks();
    _exit(write(ends[1], &counted, sizeof counted) == sizeof counted ? 0 : 1);
  }
  close(ends[1]);
  if (read(ends[0], &counted, sizeof counted) != sizeof counted) counted.started = false;
  close(ends[0]);
  waitpid(child, nullptr, 0);
  return counted;
}

TEST(ControllerTick, TenThousandTicksAllocateNothingAndMissNoPage) {
  // A page that the program touches for the first time is missed in every process. One that the
  // kernel took away meanwhile (it moves pages between memory banks and reclaims them) is not:
  // three processes may try.
  Counted counted;
  for (int attempt = 0; attempt < 3; ++attempt) {
    counted = count_in_a_fresh_process();
    ASSERT_TRUE(counted.started) << "the trial did not start, or the counter does not count";
    EXPECT_EQ(counted.allocations, 0);
    EXPECT_EQ(counted.state, wire::SupervisorState::run);
    EXPECT_EQ(counted.upper_weight, 1.0f);
    if (counted.page_faults == 0) break;
  }
  if (kShadowMemory) GTEST_SKIP() << "pages: a sanitizer's shadow memory is touched on demand";
  EXPECT_EQ(counted.page_faults, 0);
}

}  // namespace
}  // namespace sanso
