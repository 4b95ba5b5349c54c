// Laws of the statistics toolbox: known answers, calibration under the null, invariances.
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "tests/tools/diagnose/stats/made_series.h"
#include "tools/diagnose/stats/curve.h"
#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/stats/robust.h"
#include "tools/diagnose/stats/series.h"
#include "tools/diagnose/stats/significance.h"
#include "tools/diagnose/stats/smoother.h"

namespace sanso::diagnose {
namespace {

using namespace test;

TEST(Random, StreamsAreReproducibleAndNormalHasUnitVariance) {
  EXPECT_EQ(Random(1, 2).bits(), Random(1, 2).bits());
  EXPECT_NE(Random(1, 2).bits(), Random(1, 3).bits());
  const auto x = white(100000, 1);
  EXPECT_NEAR(mean(x), 0.0, 0.02);
  EXPECT_NEAR(standard_deviation(x), 1.0, 0.02);
}

TEST(Robust, QuantilesIgnoreEmptyCells) {
  const std::vector<double> x{3, NAN, 1, 2};
  EXPECT_DOUBLE_EQ(median(x), 2.0);
  EXPECT_DOUBLE_EQ(quantile(x, 0.25), 1.5);
  EXPECT_TRUE(std::isnan(median(std::vector<double>{NAN})));
}

TEST(Robust, SigmaSurvivesATenthOfOutliers) {
  auto x = white(5000, 2);
  for (std::size_t i = 0; i < 500; ++i) x[i * 10] = 1e6;
  EXPECT_NEAR(robust_sigma(x), 1.0, 0.2);
}

TEST(Autoregression, RecoversItsOwnProcess) {
  const auto x = coloured(20000, 0.8, 3);
  const Autoregression model = fit_autoregression(x, 4);
  EXPECT_NEAR(model.coefficients[0], 0.8, 0.03);
  EXPECT_NEAR(model.coefficients[1], 0.0, 0.04);
  EXPECT_NEAR(model.innovation_sigma, 1.0, 0.03);
}

TEST(Autocorrelation, TimeOfAr1IsTheClosedForm) {
  EXPECT_NEAR(autocorrelation_time(white(20000, 4)), 1.0, 0.15);
  EXPECT_NEAR(autocorrelation_time(coloured(50000, 0.8, 5)), (1 + 0.8) / (1 - 0.8), 1.2);
}

TEST(StepDownMaxT, KeepsTheFamilyWiseErrorAndFindsTheStrongOne) {
  constexpr int kTests = 40, kWorlds = 300;
  int false_alarms = 0, found = 0;
  for (int w = 0; w < kWorlds; ++w) {
    auto z = white(kTests, 1000 + w);
    for (double& v : z) v = std::abs(v);
    const bool strong = w % 2 == 0;
    if (strong) z[7] = 6.0;
    const auto p = step_down_max_t(z, 199, [&](int b, std::span<double> out) {
      Random random(kSeed, 5'000'000 + 1000 * static_cast<std::uint64_t>(w) + b);
      for (double& v : out) v = std::abs(random.normal());
    });
    found += strong && p[7] < 0.05;
    bool any = false;
    for (int i = 0; i < kTests; ++i) any |= p[i] < 0.05 && !(strong && i == 7);
    false_alarms += any;
  }
  EXPECT_EQ(found, kWorlds / 2);
  EXPECT_LT(false_alarms, 30);  // nominal 15 of 300; binomial 99.9 % bound
}

TEST(FalseDiscoveryRate, MatchesTheTextbookExample) {
  const std::vector<double> p{0.01, 0.04, 0.03, 0.5};
  const auto q = false_discovery_rate(p);
  EXPECT_NEAR(q[0], 0.04, 1e-12);
  EXPECT_NEAR(q[2], 0.04 * 4 / 3, 1e-12);
  EXPECT_NEAR(q[3], 0.5, 1e-12);
}

/// Gains of zero mean: the bound may lie above zero about as often as its level says, also where
/// neighbours depend.
TEST(MovingBlockBootstrap, LowerBoundOfCorrelatedGainsIsHonest) {
  constexpr int kSeries = 300;
  int above = 0, above_independent = 0;
  for (int i = 0; i < kSeries; ++i) {
    const auto x = coloured(120, 0.7, 100 + static_cast<std::uint64_t>(i));
    above += moving_block_lower_bound(x, 0.023, 299, Random(5)) > 0.0;
    // two standard errors of a mean of independent gains
    above_independent += mean(x) > 2.0 * standard_deviation(x) / std::sqrt(120.0);
  }
  EXPECT_LT(above, 0.07 * kSeries);
  EXPECT_GT(above_independent, 0.12 * kSeries)
      << "the same without blocks: the test would not tell them apart";
}

TEST(MovingBlockBootstrap, BoundOfIndependentGainsIsTwoDeviationsBelowTheSum) {
  Random random(9);
  std::vector<double> x(400);
  for (double& v : x) v = 1.0 + random.normal();
  const double bound = moving_block_lower_bound(x, 0.023, 2000, Random(5));
  EXPECT_NEAR(bound, 400 * mean(x) - 2.0 * 20.0, 10.0);
  EXPECT_EQ(bound, moving_block_lower_bound(x, 0.023, 2000, Random(5)));
  EXPECT_EQ(moving_block_lower_bound(std::vector<double>{3.0}, 0.023, 10, Random(1)), 3.0);
}

TEST(WilsonInterval, ContainsTheProportionAndStaysInside) {
  const Interval i = wilson_interval(0, 20);
  EXPECT_EQ(i.low, 0.0);
  EXPECT_NEAR(i.high, 0.161, 0.002);
}

TEST(ShapeCurve, ExplainsASineInNoise) {
  Random random(kSeed, 9);
  std::vector<double> x, y;
  for (int i = 0; i < 2000; ++i) {
    x.push_back(-3 + 6 * random.uniform());
    y.push_back(std::sin(x.back()) + 0.2 * random.normal());
  }
  EXPECT_GT(shape_curve(x, y, 20, 1.0).explained, 0.85);
}

TEST(Smoother, VelocityOfAQuantisedUnevenSineIsWithinItsOwnBand) {
  Random random(kSeed, 10);
  std::vector<double> t, q, dq;
  constexpr double kQuantum = 0.00153;
  for (double time = 0; time < 6; time += 0.004 + 0.003 * random.uniform()) {
    t.push_back(time);
    q.push_back(kQuantum * std::round(0.6 * std::sin(4 * time) / kQuantum));
    dq.push_back(2.4 * std::cos(4 * time));
  }
  q[100] = NAN;
  const SmoothedState s = smooth_position(t, q, kQuantum / std::sqrt(12.0));
  std::vector<double> error;
  int inside = 0;
  for (std::size_t i = 20; i + 20 < t.size(); ++i) {
    error.push_back(s.dq[i] - dq[i]);
    inside += std::abs(error.back()) < 3 * s.dq_sigma[i];
  }
  EXPECT_LT(rms(error), 0.05);  // 2 % of the amplitude
  EXPECT_GT(inside, static_cast<int>(0.95 * static_cast<double>(error.size())));
}

}  // namespace
}  // namespace sanso::diagnose
