// Which losses would show: told by what they change where the joint was, whatever was lost.
#include "tools/diagnose/explain/showing.h"

#include <gtest/gtest.h>

#include "tests/support/lossy_world.h"

namespace sanso::diagnose {
namespace {

/// Commands whose loss would show, and those lost, once the losses of one recording are taken.
Showing::Split counted(const std::vector<std::size_t>& lost, test::Goal goal) {
  const test::SmallComparison compared(
      test::pendulum(test::kServo), {test::record({}, 0, lost, test::kNoise, goal)},
      {{"q:a", 0.0, test::kNoise, {}}, {"pwm:a", 0.0, 1e-3, {}}}, {"packet_loss"});
  const Surroundings around = make_surroundings(compared.problem, compared.library, Model{});
  Hunt hunt(around, Model{}, {0});
  hunt.take_all(0);
  return Showing(hunt, {0}).count();
}

// The jumps are several times as large there; at full duty they change nothing.
TEST(Showing, NoLossShowsInADriveAtItsLimit) {
  const Showing::Split usual = counted({}, test::swing);
  const Showing::Split beyond = counted({}, test::swing_beyond_the_motor);
  EXPECT_EQ(usual.visible.lost, 0);
  EXPECT_GT(usual.visible.commands, 300);
  EXPECT_LT(beyond.visible.commands, usual.visible.commands - 100);
}

// Were a command more visible for having been lost, every share would lean to one side.
TEST(Showing, WhatWasLostShowsNoMoreForIt) {
  const std::vector<std::size_t> lost{130, 131, 222, 347, 510, 511, 512, 668, 815, 905};
  const Showing::Split clean = counted({}, test::swing), lossy = counted(lost, test::swing);
  EXPECT_NEAR(lossy.visible.commands, clean.visible.commands, 0.03 * clean.visible.commands);
  EXPECT_GE(lossy.visible.lost, 3);  // of ten, in two commands of five
  EXPECT_LE(lossy.visible.lost, 6);
}

}  // namespace
}  // namespace sanso::diagnose
