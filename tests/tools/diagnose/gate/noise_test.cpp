// Noise of a channel measured on series whose noise is known.
#include "tools/diagnose/gate/noise.h"

#include <gtest/gtest.h>

#include "tests/tools/diagnose/gate/made_recording.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// Slow motion with white noise of deviation sigma, read in steps of `quantum` (0: none).
std::vector<double> noisy(double sigma, double quantum, std::uint64_t seed,
                          double amplitude = 0.5) {
  Random random(seed);
  std::vector<double> x;
  for (int k = 0; k < 3000; ++k) {
    const double v = amplitude * std::sin(0.004 * k) + sigma * random.normal();
    x.push_back(quantum > 0.0 ? quantum * std::round(v / quantum) : v);
  }
  return x;
}

TEST(QuantisationStep, OfEveryEncoderIsFound) {
  for (int bits = 9; bits <= 18; ++bits) {
    const double step = std::ldexp(6.283185307179586, -bits);
    const auto seed = static_cast<std::uint64_t>(bits);
    const double found = quantisation_step(noisy(0.4 * step, step, seed, 200 * step));
    EXPECT_NEAR(found / step, 1.0, 1e-3) << bits << " bits";
  }
}

TEST(QuantisationStep, ScalesWithTheUnitAndForgetsTheOffset) {
  std::vector<double> x = noisy(0.001, 0.002, 3);
  const double step = quantisation_step(x);
  for (double& v : x) v = 57.3 * v + 11.0;
  EXPECT_NEAR(quantisation_step(x), 57.3 * step, 1e-6);
}

TEST(QuantisationStep, OfAContinuousChannelIsNone) {
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    EXPECT_EQ(quantisation_step(noisy(1e-3, 0.0, seed)), 0.0) << seed;
}

TEST(QuantisationStep, OfTooLittleIsNone) {
  EXPECT_EQ(quantisation_step(std::vector<double>(100, 0.25)), 0.0) << "it never changes";
  const std::vector<double> x = noisy(0.001, 0.002, 4);
  EXPECT_EQ(quantisation_step(std::span(x).first(19)), 0.0);
}

TEST(NoiseLevel, IsTheDeviationThatWasPutIn) {
  // the mean of twenty series: 5 % is ten times its standard error. Choosing the windows in which
  // the noise itself is smallest would show as a sixth too little.
  for (const double sigma : {1e-4, 3e-3, 0.02}) {
    double sum = 0.0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const NoiseLevel level = noise_level("q:hip", noisy(sigma, 0.0, 50 + seed), GateSettings{});
      EXPECT_EQ(level.quantum, 0.0);
      EXPECT_EQ(level.channel, "q:hip");
      sum += level.sigma / 20.0;
    }
    EXPECT_NEAR(sum / sigma, 1.0, 0.05) << sigma;
  }
}

TEST(NoiseLevel, IsJudgedWhereTheReadingChanges) {
  // three quarters of the recording at rest inside one step of the encoder: no noise is seen there
  std::vector<double> x = noisy(2 * kQuantum, kQuantum, 11, 0.3);
  const double moving = noise_level("q:hip", x, GateSettings{}).sigma;
  std::vector<double> rested(9000, x.front());
  rested.insert(rested.end(), x.begin(), x.end());
  EXPECT_NEAR(noise_level("q:hip", rested, GateSettings{}).sigma / moving, 1.0, 0.1);
}

TEST(NoiseLevel, ScalesWithTheUnit) {
  std::vector<double> x = noisy(1e-3, 0.0, 6);
  const double before = noise_level("q:hip", x, GateSettings{}).sigma;
  scale(x, 57.3);
  EXPECT_NEAR(noise_level("q:hip", x, GateSettings{}).sigma, 57.3 * before, 1e-9);
}

TEST(NoiseLevel, IsNeverBelowWhatRoundingMakes) {
  // held still inside one step, then moved: differences say nothing of the step's own error
  std::vector<double> x = noisy(0.0, kQuantum, 7, 0.05);
  const NoiseLevel level = noise_level("q:hip", x, GateSettings{});
  EXPECT_NEAR(level.quantum, kQuantum, 1e-6);
  EXPECT_GE(level.sigma, level.quantum / std::sqrt(12.0));
}

TEST(NoiseLevel, DoesNotCountTheMotionNorOneGlitch) {
  std::vector<double> x = noisy(1e-3, 0.0, 8, 2.0);
  x[1200] += 5.0;
  EXPECT_NEAR(noise_level("q:hip", x, GateSettings{}).sigma, 1e-3, 2e-4);
}

TEST(NoiseLevel, EmptyCellsAreLeftOut) {
  std::vector<double> x = noisy(1e-3, 0.0, 9), holes;
  for (const double v : x) {
    holes.push_back(v);
    holes.push_back(NAN);
  }
  EXPECT_EQ(noise_level("q:hip", holes, GateSettings{}).sigma,
            noise_level("q:hip", x, GateSettings{}).sigma);
}

TEST(NoiseLevel, ColourIsOnlySaidWhereThereIsStandstill) {
  const std::vector<double> x = noisy(1e-3, 0.0, 10);
  EXPECT_EQ(noise_level("q:hip", x, GateSettings{}).colour.size(), 4u);
  EXPECT_TRUE(noise_level("q:hip", std::span(x).first(120), GateSettings{}).colour.empty());
}

TEST(CalmWindows, AreTheQuarterThatMovesLeast) {
  std::vector<double> x;
  for (int k = 0; k < 800; ++k) x.push_back(k < 200 ? 1e-3 * (k % 2) : 0.02 * k);
  const auto windows = calm_windows(x, 40);
  ASSERT_EQ(windows.size(), 5u);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    EXPECT_EQ(windows[w].first, 40 * w);
    EXPECT_EQ(windows[w].second, 40 * (w + 1));
  }
  EXPECT_TRUE(calm_windows(std::span(x).first(39), 40).empty());
}

}  // namespace
}  // namespace sanso::diagnose
