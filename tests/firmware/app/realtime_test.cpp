// After arming nothing allocates and no page is missed: 10 000 ticks of a trial with all three layers.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tools/bench/tick_rig.h"

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

TEST(ControllerTick, TenThousandTicksAllocateNothingAndMissNoPage) {
  const long before_setup = allocations;
  bench::TickRig rig;
  ASSERT_GT(allocations, before_setup) << "the counter does not count";
  ASSERT_TRUE(rig.start_trial());
  for (int i = 0; i < 600; ++i) rig.tick();  // every page of the tables has been read once
  const long allocated = allocations, missed = page_faults();
  for (int i = 0; i < 10'000; ++i) rig.tick();
  EXPECT_EQ(allocations, allocated);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_EQ(page_faults(), missed);
#else
  (void)missed;  // a sanitizer's shadow memory is touched on demand
#endif
  EXPECT_EQ(rig.controller().state(), wire::SupervisorState::run);
  EXPECT_EQ(rig.controller().observation().upper_weight, 1.0f);
}

}  // namespace
}  // namespace sanso
