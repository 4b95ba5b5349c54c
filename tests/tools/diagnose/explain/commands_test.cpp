// Commands that may be lost: which act in a shot, which would be noticed, and sets of losses.
#include "tools/diagnose/explain/commands.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

using namespace test;

class CommandsOfAWorld : public ::testing::Test {
 protected:
  CommandsOfAWorld() { params_ = c_.problem->sources[0].nominal; }
  SmallComparison c_ = compared(pendulum(kNoisyServo), {}, {"coulomb_friction"}, 1);
  SimParams params_;
};

TEST_F(CommandsOfAWorld, AreThoseOfTheRecordings) {
  const Commands commands(c_.problem.comparison, params_);
  for (std::size_t source = 0; source < 2; ++source) {
    const std::vector<double>& u = commands.of(source, 0);
    for (std::size_t row = 1; row < u.size(); ++row) {
      EXPECT_EQ(commands.changes(source, 0, row), u[row] != u[row - 1]);
      EXPECT_EQ(commands.missed(source, 0, row, 1), u[row] - u[row - 1]);
    }
  }
}

TEST_F(CommandsOfAWorld, AHeldRunMissesTheSumOfWhatItDidNotFollow) {
  const Commands commands(c_.problem.comparison, params_);
  const std::vector<double>& u = commands.of(0, 0);
  EXPECT_EQ(commands.missed(0, 0, 70, 1), u[70] - u[69]);
  const double three = u[70] + u[71] + u[72] - 3.0 * u[69];
  EXPECT_NEAR(commands.missed(0, 0, 70, 3), three, 1e-15);
  EXPECT_EQ(commands.missed(0, 0, u.size() - 1, 9), u[u.size() - 1] - u[u.size() - 2])
      << "beyond the end there is nothing to miss";
}

TEST_F(CommandsOfAWorld, StillUnderWayAtTheStartOfAShotCountForIt) {
  const Shot& shot = c_.problem->shots[4];
  EXPECT_EQ(Commands(c_.problem.comparison, params_).first_row(shot, 0), shot.window.first);
  params_.joints[0].command_delay = 0.02, params_.joints[0].sensor_delay = 0.01;
  EXPECT_EQ(Commands(c_.problem.comparison, params_).first_row(shot, 0), shot.window.first - 3);
  params_.joints[0].command_delay = 1e3;
  EXPECT_EQ(Commands(c_.problem.comparison, params_).first_row(shot, 0), 1u)
      << "row 0 has none before it";
}

TEST_F(CommandsOfAWorld, ThatStayOrAreEmptyCannotBeMissed) {
  const Commands as_sent(c_.problem.comparison, params_);
  const double before = as_sent.count({0});
  ASSERT_TRUE(as_sent.changes(0, 0, 60));
  const auto other = std::make_shared<Comparison>(*c_.problem);
  std::vector<double>& u = other->sources[0].drive.joints[0].command;
  const Commands commands(other, params_);
  for (std::size_t row = 60; row < 80; ++row) u[row] = u[59];
  EXPECT_FALSE(commands.changes(0, 0, 60));
  EXPECT_LE(commands.count({0}), before - 18);
  u[120] = NAN;
  EXPECT_FALSE(commands.changes(0, 0, 120));
  EXPECT_FALSE(commands.changes(0, 0, 121));
  EXPECT_FALSE(commands.changes(0, 0, u.size())) << "beyond the end there is none";
}

TEST(Losses, PutTwiceIsAsItWas) {
  Shot shot;
  shot.source = 2;
  Random random(1);
  std::vector<LostCommand> lost;
  for (int k = 0; k < 200; ++k) {
    Change change;
    change.row = static_cast<std::size_t>(random.below(50)), change.run = 1;
    const std::vector<LostCommand> before = lost;
    put(lost, shot, 1, change);
    std::vector<LostCommand> back = lost;
    put(back, shot, 1, change);
    ASSERT_EQ(back.size(), before.size());
    EXPECT_TRUE(std::is_sorted(lost.begin(), lost.end()));
    EXPECT_NE(holds(lost, {2, 1, change.row}), holds(before, {2, 1, change.row}));
  }
}

TEST(Losses, OfARunAreAllOfItAndNoneTwice) {
  Shot shot;
  std::vector<LostCommand> lost{{0, 0, 12}};
  Change run;
  run.row = 10, run.run = 5;
  put(lost, shot, 0, run);
  ASSERT_EQ(lost.size(), 5u);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(lost[k].row, 10 + k);
}

TEST(Losses, BetweenAreThoseOfTheJointInTheRows) {
  std::vector<LostCommand> lost;
  for (std::size_t source = 0; source < 2; ++source) {
    for (std::size_t joint = 0; joint < 2; ++joint) {
      for (std::size_t row = 5; row < 40; row += 5) lost.push_back({source, joint, row});
    }
  }
  const std::vector<LostCommand> some = between(lost, 1, 0, 10, 25);
  ASSERT_EQ(some.size(), 3u);
  for (const LostCommand& one : some) {
    EXPECT_EQ(one.source, 1);
    EXPECT_EQ(one.joint, 0);
    EXPECT_GE(one.row, 10u);
    EXPECT_LT(one.row, 25u);
  }
  EXPECT_TRUE(between(lost, 3, 0, 0, 100).empty());
}

}  // namespace
}  // namespace sanso::diagnose
