// The parallel loop: every piece once, the first failure kept, an end on request.
#include "shared/files/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace sanso::files {
namespace {

TEST(Parallel, DoesEveryPieceOnceForAnyNumberOfThreads) {
  for (const int threads : {-1, 0, 1, 2, 7, 300}) {
    std::vector<int> done(200, 0);
    parallel_for(done.size(), threads, [&](std::size_t i) { ++done[i]; });
    EXPECT_EQ(done, std::vector<int>(200, 1)) << threads << " threads";
  }
}

TEST(Parallel, NothingToDoCallsNothing) {
  parallel_for(0, 4, [](std::size_t) { FAIL() << "no piece was there"; });
}

TEST(Parallel, RethrowsWhatAWorkerThrewAndStartsNoMore) {
  for (const int threads : {1, 4}) {
    std::atomic<int> started{0};
    const auto work = [&](std::size_t i) {
      ++started;
      if (i == 3) throw std::runtime_error("piece 3");
    };
    try {
      parallel_for(100000, threads, work);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "piece 3");
    }
    EXPECT_GE(started.load(), 1);
    EXPECT_TRUE(threads > 1 || started.load() == 4) << started.load();
  }
}

TEST(Parallel, EndsAtTheNextPieceWhenAsked) {
  StopRequest stop;
  int done = 0;
  const auto work = [&](std::size_t i) {
    ++done;
    if (i == 9) stop.request();
  };
  EXPECT_THROW(parallel_for(100, 1, work, &stop), Stopped);
  EXPECT_EQ(done, 10);
  EXPECT_THROW(parallel_for(100, 4, work, &stop), Stopped);
  EXPECT_EQ(done, 10) << "a loop began after the request";
}

TEST(Parallel, AFailureIsToldBeforeAStop) {
  StopRequest stop;
  const auto work = [&](std::size_t) {
    stop.request();
    throw std::runtime_error("lost");
  };
  EXPECT_THROW(parallel_for(4, 2, work, &stop), std::runtime_error);
}

/// Waits until `count` threads are here; not forever.
bool meet(std::atomic<int>& here, int count) {
  ++here;
  const auto enough = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (here < count) {
    if (std::chrono::steady_clock::now() > enough) return false;
    std::this_thread::yield();
  }
  return true;
}

TEST(Parallel, ThreadsWithoutWorkHelpTheLoopInsideAnothersPiece) {
  // the outer loop has a piece for one thread alone; the inner one needs both at once
  std::atomic<int> here{0}, met{0};
  parallel_for(2, 2, [&](std::size_t outer) {
    if (outer == 0) return;
    parallel_for(2, 2, [&](std::size_t) { met += meet(here, 2); });
  });
  EXPECT_EQ(met, 2);
}

TEST(Parallel, AThreadThatWaitsForItsLoopHelpsTheLoopsInside) {
  // Two threads do a piece each of the middle loop; whichever ends first has only the other's
  // inner loop left to help.
  std::atomic<int> first{0}, here{0}, met{0};
  parallel_for(1, 2, [&](std::size_t) {
    parallel_for(2, 2, [&](std::size_t) {
      if (first++ == 0) return;
      parallel_for(2, 2, [&](std::size_t) { met += meet(here, 2); });
    });
  });
  EXPECT_EQ(met, 2);
}

TEST(Parallel, LoopsInsideLoopsDoEveryPieceOnceWithTheThreadsOfTheOuterOne) {
  for (const int threads : {1, 2, 3, 8}) {
    std::mutex guard;
    std::set<std::thread::id> seen;
    std::vector<std::atomic<int>> done(6 * 5 * 4);
    parallel_for(6, threads, [&](std::size_t i) {
      parallel_for(5, 64, [&](std::size_t j) {
        parallel_for(4, 64, [&](std::size_t k) {
          ++done[(i * 5 + j) * 4 + k];
          const std::lock_guard lock(guard);
          seen.insert(std::this_thread::get_id());
        });
      });
    });
    for (const std::atomic<int>& d : done) EXPECT_EQ(d, 1);
    EXPECT_LE(seen.size(), static_cast<std::size_t>(std::min(threads, 6)));
  }
}

TEST(Parallel, AFailureInsideALoopInsideEndsBoth) {
  for (const int threads : {1, 2, 4}) {
    EXPECT_THROW(parallel_for(100, threads,
                              [&](std::size_t) {
                                parallel_for(100, threads, [](std::size_t j) {
                                  if (j == 7) throw std::runtime_error("inner");
                                });
                              }),
                 std::runtime_error);
  }
}

TEST(Parallel, AWideLoopMayFollowANarrowOne) {
  parallel_for(8, 1, [](std::size_t) {});
  std::atomic<int> here{0}, met{0};
  parallel_for(2, 2, [&](std::size_t) { met += meet(here, 2); });
  EXPECT_EQ(met, 2);
}

}  // namespace
}  // namespace sanso::files
