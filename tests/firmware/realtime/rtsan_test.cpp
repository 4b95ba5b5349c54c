// The tick under RealtimeSanitizer: whoever allocates, locks, opens or sleeps in it ends the
// program with a report. Controller::tick is compiled by the newest clang (CMakeLists.txt); what it
// calls is whatever the tree's compiler has made.
#include <gtest/gtest.h>
#include <unistd.h>

#include <memory>
#include <mutex>

#include "tools/bench/tick_rig.h"
#include "tools/campaign/soak.h"

namespace sanso {
namespace {

/// A bus that breaks the promise of board.h: it does something in the middle of a tick.
template <class Misdeed>
class BadBus : public board::SerialPort {
 public:
  explicit BadBus(Misdeed misdeed) : misdeed_(misdeed) {}
  Status write(board::Bytes) override {
    misdeed_();
    return Status::ok;
  }
  Result<std::size_t> read(board::Buffer, Nanoseconds) override { return std::size_t{0}; }
  Status ready() override { return Status::ok; }

 private:
  Misdeed misdeed_;
};

template <class Misdeed>
void tick_with(Misdeed misdeed) {
  BadBus bus(misdeed);
  bench::RigClock clock;
  const auto handover = std::make_unique<firmware::Handover>();
  firmware::Controller controller(firmware::Settings{}, bus, clock, *handover);
  for (Nanoseconds now = kTickPeriod; now < kSecond; now += kTickPeriod) {
    clock.set(now);
    controller.tick(now);
  }
}

TEST(TickUnderTheRealtimeSanitizer, SeesWhatATickMustNotDo) {
  testing::GTEST_FLAG(death_test_style) = "threadsafe";
  EXPECT_DEATH(tick_with([] { delete new volatile int(1); }), "RealtimeSanitizer.*");
  EXPECT_DEATH(tick_with([] {
                 std::mutex mutex;
                 const std::lock_guard lock(mutex);
               }),
               "pthread_mutex_lock");
  EXPECT_DEATH(tick_with([] { usleep(1); }), "usleep");
  tick_with([] {});
}

TEST(TickUnderTheRealtimeSanitizer, ATrialOfAllThreeLayers) {
  bench::TickRig rig;
  ASSERT_TRUE(rig.start_trial());
  for (int i = 0; i < 2000; ++i) rig.tick();
  EXPECT_EQ(rig.controller().state(), wire::SupervisorState::run);
  EXPECT_EQ(rig.controller().observation().upper_weight, 1.0f);
}

TEST(TickUnderTheRealtimeSanitizer, FaultsDrawnByChanceAndHostsThatDoAnything) {
  campaign::SoakOptions options;
  options.ticks = 40'000;
  options.seed = 3;
  options.world = "hung";
  EXPECT_EQ(campaign::bench_soak(options), 0);
}

}  // namespace
}  // namespace sanso
