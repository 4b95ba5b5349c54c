// The thread pool: every item once, with any number of threads, across many phases and sessions.
#include "host/mpc/spin_pool.h"

#include <gtest/gtest.h>

#include <array>

namespace sanso::mpc {
namespace {

TEST(SpinPool, EveryItemRunsOnceInEveryPhase) {
  for (const int threads : {1, 2, 4}) {
    SpinPool pool(threads, false);
    std::array<std::atomic<int>, 77> counts{};
    for (int session = 0; session < 20; ++session) {
      const SpinPool::Session open(pool);
      for (int phase = 0; phase < 10; ++phase)
        pool.run(static_cast<int>(counts.size()), [&](int item, int thread) {
          ASSERT_LT(thread, threads);
          counts[static_cast<std::size_t>(item)].fetch_add(1, std::memory_order_relaxed);
        });
    }
    for (const auto& count : counts) EXPECT_EQ(count.load(), 200);
  }
}

TEST(SpinPool, APhaseSeesWhatTheOneBeforeWrote) {
  SpinPool pool(3, false);
  const SpinPool::Session open(pool);
  std::array<int, 64> value{};  // plain memory: the phase border is the only synchronisation
  for (int phase = 0; phase < 200; ++phase)
    pool.run(64,
             [&](int item, int) {
               const int other = value[static_cast<std::size_t>((item * 7 + phase) % 64)];
               (void)other;
             }),
        pool.run(64, [&](int item, int) { ++value[static_cast<std::size_t>(item)]; });
  for (const int v : value) EXPECT_EQ(v, 200);
}

TEST(SpinPool, WorksWithoutAnOpenSession) {
  SpinPool pool(2, true);  // helpers may sleep: the caller does the work alone
  std::atomic<int> sum{0};
  pool.run(100, [&](int item, int) { sum += item; });
  EXPECT_EQ(sum.load(), 4950);
}

TEST(SpinPool, TheCallerMayHelpBetweenBeginAndFinish) {
  for (const int threads : {1, 3}) {
    SpinPool pool(threads, false);
    const SpinPool::Session open(pool);
    for (int phase = 0; phase < 100; ++phase) {
      std::atomic<int> sum{0};
      const auto task = [&](int item, int) { sum += item; };
      pool.begin(100, task);
      while (sum < 1000) pool.help();
      pool.finish();
      EXPECT_EQ(sum.load(), 4950);
      EXPECT_FALSE(pool.help());
    }
  }
}

}  // namespace
}  // namespace sanso::mpc
