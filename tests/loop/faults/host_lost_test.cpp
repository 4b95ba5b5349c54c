// The host dies in mid-squat: the robot finishes into hold on its feet, whenever it happens.
#include <random>

#include "tests/loop/support/loop_fixture.h"

namespace sanso::loop {
namespace {

TEST(HostLost, TheRobotFinishesIntoHoldWithoutAFall) {
  Loop loop("squat");
  constexpr std::uint32_t kSeed = 20;
  RecordProperty("seed", kSeed);
  std::mt19937 rng(kSeed);
  const int first = 60, last = loop.setup.duration_ticks - 60;
  for (int i = 0; i < 20; ++i) {
    const int kill_tick = first + static_cast<int>(rng() % static_cast<unsigned>(last - first));
    loop.stand(static_cast<std::uint64_t>(i));
    loop.robot().lose_host_at(kill_tick);
    (void)learn::run_trial(*loop.link, loop.upper, loop.setup, loop.settings);
    loop.robot().run_for(5.0);
    EXPECT_EQ(loop.robot().controller().state(), wire::SupervisorState::hold)
        << "killed at tick " << kill_tick;
    EXPECT_EQ(loop.robot().controller().fault(), firmware::Fault::none)
        << "killed at tick " << kill_tick;
    EXPECT_TRUE(loop.on_its_feet())
        << "killed at tick " << kill_tick << ", trunk at " << loop.true_height() << " m";
  }
}

}  // namespace
}  // namespace sanso::loop
