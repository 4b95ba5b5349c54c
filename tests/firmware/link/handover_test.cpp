// Queues and mailboxes between two real threads: order kept, nothing torn, nothing lost that was
// accepted.
#include <gtest/gtest.h>

#include <array>
#include <thread>

#include "firmware/exchange/mailbox.h"
#include "firmware/exchange/spsc_ring.h"

namespace sanso::firmware {
namespace {

TEST(SpscRing, FullAndEmptyAreSaid) {
  SpscRing<int, 4> ring;
  int out = 0;
  EXPECT_FALSE(ring.pop(out));
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(ring.push(i));
  EXPECT_FALSE(ring.push(4));
  EXPECT_EQ(ring.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    ASSERT_TRUE(ring.pop(out));
    EXPECT_EQ(out, i);
  }
  EXPECT_FALSE(ring.pop(out));
}

TEST(SpscRing, KeepsTheOrderAcrossThreads) {
  SpscRing<int, 64> ring;
  constexpr int kCount = 200'000;
  std::thread producer([&] {
    for (int i = 0; i < kCount;)
      if (ring.push(i))
        ++i;
      else
        std::this_thread::yield();
  });
  for (int expected = 0; expected < kCount;) {
    int out = 0;
    if (!ring.pop(out)) {
      std::this_thread::yield();
      continue;
    }
    ASSERT_EQ(out, expected);
    ++expected;
  }
  producer.join();
}

TEST(Mailbox, TheReaderSeesWholeValuesAndNeverAnOlderOne) {
  using Block = std::array<int, 256>;
  Mailbox<Block> mailbox;
  constexpr int kCount = 20'000;
  std::thread producer([&] {
    for (int i = 1; i <= kCount; ++i) {
      mailbox.back().fill(i);
      mailbox.publish();
    }
  });
  int last = 0;
  while (last < kCount) {
    if (!mailbox.update()) {
      std::this_thread::yield();
      continue;
    }
    const Block& block = mailbox.front();
    ASSERT_GT(block[0], last);
    for (const int v : block) ASSERT_EQ(v, block[0]);
    last = block[0];
  }
  producer.join();
  EXPECT_FALSE(mailbox.update());
}

}  // namespace
}  // namespace sanso::firmware
