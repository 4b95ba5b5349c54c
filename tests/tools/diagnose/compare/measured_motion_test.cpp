// The motion that a recording shows: its noise, its windows, and what it is where nothing is known.
#include "tools/diagnose/compare/measured_motion.h"

#include <gtest/gtest.h>

#include "tests/support/noisy_world.h"
#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// Six seconds at 100 Hz of a slow sine with noise of `sigma`.
Drive sine(double sigma, std::uint64_t seed = 1) {
  Random random(seed);
  Drive drive = make_test_drive(pendulum("actuator = \"passive\"\n"), 6.0, 0.01,
                                [](int, double) { return 0.0; });
  for (std::size_t k = 0; k < drive.rows(); ++k)
    drive.joints[0].q[k] = 0.5 * std::sin(2.0 * drive.t[k]) + sigma * random.normal();
  return drive;
}

TEST(PositionNoise, IsTheDeviationOfTheNoise) {
  for (const double sigma : {1e-4, 1e-3, 1e-2})
    EXPECT_NEAR(position_noise(sine(sigma).joints[0].q) / sigma, 1.0, 0.2) << sigma;
}

TEST(PositionNoise, OfAnEncoderIsAtLeastThatOfItsSteps) {
  std::vector<double> q = sine(0.0).joints[0].q;
  for (double& x : q) x = 0.01 * std::round(x / 0.01);
  EXPECT_GE(position_noise(q), 0.01 / std::sqrt(12.0) * 0.99);
}

TEST(MeasuredMotion, FollowsTheMotionAndItsSpeed) {
  const Drive drive = sine(1e-3);
  const MeasuredMotion motion = measured_motion(drive, Settings{});
  std::vector<double> position, speed;
  for (std::size_t k = 10; k + 10 < drive.rows(); ++k) {
    position.push_back(motion.q[0][k] - 0.5 * std::sin(2.0 * drive.t[k]));
    speed.push_back(motion.dq[0][k] - std::cos(2.0 * drive.t[k]));
  }
  EXPECT_LT(rms(position), 5e-4) << "half of the noise of a reading";
  EXPECT_LT(rms(speed), 0.02);
}

TEST(MeasuredMotion, DoesNotFollowOneGlitch) {
  Drive drive = sine(1e-3);
  const MeasuredMotion before = measured_motion(drive, Settings{});
  drive.joints[0].q[300] += 2.0;
  const MeasuredMotion after = measured_motion(drive, Settings{});
  // in its place stands the median of five rows: off by no more than the motion of a row
  for (std::size_t k = 290; k < 310; ++k) EXPECT_NEAR(after.q[0][k], before.q[0][k], 0.01) << k;
}

TEST(MeasuredMotion, GoesThroughCellsThatWereNotSampled) {
  Drive drive = sine(1e-3);
  for (std::size_t k = 200; k < 210; ++k) drive.joints[0].q[k] = NAN;
  const MeasuredMotion motion = measured_motion(drive, Settings{});
  for (std::size_t k = 195; k < 215; ++k)
    EXPECT_NEAR(motion.q[0][k], 0.5 * std::sin(2.0 * drive.t[k]), 0.01) << k;
}

TEST(TiledWindows, CoverTheRecordingOnceInOrder) {
  const Drive drive = sine(1e-3);
  const MeasuredMotion motion = measured_motion(drive, Settings{});
  for (const double seconds : {0.1, 0.37, 0.5, 2.0}) {
    const std::vector<Window> windows = tiled_windows(drive, motion, seconds);
    EXPECT_EQ(windows.front().first, 0u);
    for (std::size_t w = 0; w < windows.size(); ++w) {
      const double length = drive.t[windows[w].last] - drive.t[windows[w].first];
      EXPECT_GT(length, 0.49 * seconds);
      EXPECT_LT(length, seconds + 0.011);
      EXPECT_EQ(windows[w].q[0], motion.q[0][windows[w].first]);
      EXPECT_EQ(windows[w].dq[0], motion.dq[0][windows[w].first]);
      if (w > 0) {
        EXPECT_GE(windows[w].first, windows[w - 1].last);
        EXPECT_LE(windows[w].first, windows[w - 1].last + 1);
      }
    }
    EXPECT_GT(drive.t[windows.back().last], 6.0 - seconds);
  }
}

TEST(TiledWindows, OfEndlessLengthAreOne) {
  const Drive drive = sine(1e-3);
  const auto windows = tiled_windows(drive, measured_motion(drive, Settings{}), INFINITY);
  ASSERT_EQ(windows.size(), 1u);
  EXPECT_EQ(windows[0].last, drive.rows() - 1);
}

}  // namespace
}  // namespace sanso::diagnose
