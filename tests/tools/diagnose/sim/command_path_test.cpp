// The command between two instants: held, delayed, averaged, lost, switched off.
#include "tools/diagnose/sim/command_path.h"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/support/small_world.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// Of joint 0, without a place to go on from.
CommandPath::Command at(const CommandPath& path, double from, double until) {
  std::size_t cursor = CommandPath::kUnset;
  return path.over(0, from, until, cursor);
}

/// A pendulum whose command is row number k at instant 0.01 k.
struct Path {
  Path()
      : model(pendulum("actuator = \"position_pd\"\nkp = 1\n")),
        params(make_params(model)),
        drive(
            make_test_drive(model, 0.5, 0.01, [](int, double t) { return std::round(100 * t); })) {}
  CommandPath::Command over(double from, double until, std::uint64_t seed = 0) {
    return at(CommandPath(params, drive, seed), from, until);
  }
  ModelFolder model;
  SimParams params;
  Drive drive;
};

TEST(CommandPath, HoldsACommandUntilTheNext) {
  Path p;
  for (const double at : {0.1005, 0.104, 0.108}) EXPECT_EQ(p.over(at, at + 0.001).value, 10.0);
  EXPECT_EQ(p.over(0.4995, 0.4999).value, 49.0);
  EXPECT_EQ(p.over(0.6, 0.7).value, 50.0) << "after the last row";
  EXPECT_EQ(p.over(-0.2, -0.1).value, 0.0) << "before the first row";
}

TEST(CommandPath, AcrossAChangeItIsTheMean) {
  Path p;
  EXPECT_NEAR(p.over(0.105, 0.115).value, 10.5, 1e-9);
  EXPECT_NEAR(p.over(0.108, 0.118).value, 10.8, 1e-9);
  EXPECT_NEAR(p.over(0.10, 0.15).value, 12.0, 1e-9);
}

TEST(CommandPath, PartsAddUpToTheWhole) {
  Path p;
  Random random(1);
  for (int k = 0; k < 50; ++k) {
    const double a = 0.4 * random.uniform(), c = a + 0.05 * random.uniform() + 1e-4;
    const double b = a + (c - a) * random.uniform();
    const double parts = p.over(a, b).value * (b - a) + p.over(b, c).value * (c - b);
    EXPECT_NEAR(parts, p.over(a, c).value * (c - a), 1e-9);
  }
}

TEST(CommandPath, ADelayIsAnEarlierInstant) {
  Path p, late;
  late.params.joints[0].nominal.command_delay_s = 0.013;
  late.params.joints[0].command_delay = 0.009;
  for (const double t : {0.05, 0.1234, 0.3})
    EXPECT_NEAR(late.over(t, t + 0.004).value, p.over(t - 0.022, t - 0.018).value, 1e-9);
}

TEST(CommandPath, TheRateIsThatOfTheRows) {
  Path p;
  EXPECT_NEAR(p.over(0.201, 0.209).rate, 100.0, 1e-9);
  EXPECT_EQ(p.over(0.001, 0.002).rate, 0.0) << "nothing before the first row";
}

TEST(CommandPath, EveryNthCommandIsTakenAndHeld) {
  Path p;
  p.params.joints[0].hold_cycles = 4;
  for (int k = 0; k < 50; ++k)
    EXPECT_EQ(p.over(0.01 * k + 0.002, 0.01 * k + 0.008).value, 4 * (k / 4)) << k;
}

TEST(CommandPath, LossOnAverageIsALagOfTheExpectedHold) {
  // u_k = (1 - p) k + p u_{k-1}: a ramp lags by p / (1 - p) rows
  Path p;
  p.params.joints[0].loss = 0.5;
  EXPECT_NEAR(p.over(0.402, 0.408).value, 40.0 - 1.0, 1e-6);
}

TEST(CommandPath, DrawnLossKeepsTheCommandBeforeAndIsTheSameForOneSeed) {
  Path p;
  p.params.joints[0].loss = 0.3;
  const CommandPath a(p.params, p.drive, 7), b(p.params, p.drive, 7), c(p.params, p.drive, 8);
  int lost = 0, differs = 0;
  double before = 0.0;
  for (int k = 1; k < 50; ++k) {
    const double from = 0.01 * k + 0.002, until = from + 0.004;
    const double value = at(a, from, until).value;
    EXPECT_EQ(value, at(b, from, until).value);
    differs += value != at(c, from, until).value;
    EXPECT_TRUE(value == k || value == before) << value;
    lost += value != k;
    before = value;
  }
  EXPECT_NEAR(lost, 0.3 * 49, 4 * std::sqrt(49 * 0.21));
  EXPECT_GT(differs, 0);
}

/// Every command of a second lies 1 above the one before, 10 ms apart.
TEST(CommandPath, WaitsThatAreDrawnMoveNoCommandFartherThanTheyLast) {
  Path p;
  p.params.joints[0].command_scatter = 0.002;
  const CommandPath never(p.params, p.drive, 0), drawn(p.params, p.drive, 5),
      again(p.params, p.drive, 5), other(p.params, p.drive, 6);
  double sum = 0.0, most = 0.0;
  bool differs = false;
  for (std::size_t k = 0; k < p.drive.rows(); ++k) {
    EXPECT_EQ(never.series(0)[k], p.drive.joints[0].command[k]) << "nothing scatters undrawn";
    EXPECT_EQ(drawn.series(0)[k], again.series(0)[k]);
    const double off = drawn.series(0)[k] - p.drive.joints[0].command[k];
    differs = differs || drawn.series(0)[k] != other.series(0)[k];
    sum += off, most = std::max(most, std::abs(off));
  }
  EXPECT_TRUE(differs);
  EXPECT_LT(std::abs(sum) / static_cast<double>(p.drive.rows()), 0.05) << "early as often as late";
  EXPECT_GT(most, 0.1);
  EXPECT_LE(most, 0.2 + 1e-9) << "2 of 10 ms";
}

TEST(CommandPath, AnEmptyCellIsOffUntilTheNextCommand) {
  Path p;
  p.drive.joints[0].command[20] = NAN;
  EXPECT_FALSE(p.over(0.192, 0.198).off);
  EXPECT_TRUE(p.over(0.202, 0.208).off);
  EXPECT_FALSE(p.over(0.212, 0.218).off);
  EXPECT_EQ(p.over(0.212, 0.218).rate, 0.0) << "no rate from an empty cell";
}

TEST(CommandPath, AJointWithoutCommandsIsOffForEver) {
  Path p;
  p.drive.joints[0].command.clear();
  EXPECT_TRUE(p.over(0.1, 0.2).off);
}

TEST(CommandPath, ACursorThatGoesForwardFindsWhatAFreshOneFinds) {
  Path p;
  const CommandPath path(p.params, p.drive, 0);
  std::size_t cursor = CommandPath::kUnset;
  for (double t = 0.0; t < 0.6; t += 0.0037)
    EXPECT_EQ(path.over(0, t, t + 0.003, cursor).value, at(path, t, t + 0.003).value) << t;
}

}  // namespace
}  // namespace sanso::diagnose
