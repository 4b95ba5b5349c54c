// The parallel loop: every piece once, the first failure kept, an end on request.
#include "shared/files/parallel.h"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

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

TEST(Parallel, ALoopInsideAPieceStaysOnItsThread) {
  std::mutex guard;
  std::set<std::thread::id> outside, inside;
  parallel_for(8, 3, [&](std::size_t) {
    const auto mine = std::this_thread::get_id();
    parallel_for(8, 3, [&](std::size_t) {
      const std::lock_guard lock(guard);
      outside.insert(mine);
      inside.insert(std::this_thread::get_id());
    });
  });
  EXPECT_EQ(inside, outside);
  // and the caller may start a wide loop again
  std::atomic<int> waiting{0};
  parallel_for(2, 2, [&](std::size_t) {
    ++waiting;
    while (waiting < 2) std::this_thread::yield();
  });
}

}  // namespace
}  // namespace sanso::files
