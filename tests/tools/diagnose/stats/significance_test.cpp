// Tail probabilities against exact values; many tests at once and intervals against their
// definitions and their coverage.
#include "tools/diagnose/stats/significance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "tests/tools/diagnose/stats/made_series.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// P(X > x) of chi-square with an even number of degrees of freedom: a Poisson sum.
double exact_chi_square_tail(double x, int k) {
  double term = std::exp(-x / 2), sum = 0.0;
  for (int i = 0; i < k / 2; ++i) sum += term, term *= x / 2 / (i + 1);
  return sum;
}

TEST(NormalTail, IsTheTableOfTheNormalDistribution) {
  const std::pair<double, double> table[] = {{0.0, 0.5},
                                             {1.0, 0.15865525393145707},
                                             {1.959963984540054, 0.025},
                                             {3.0, 0.0013498980316300946},
                                             {6.0, 9.865876450376946e-10}};
  for (const auto& [z, p] : table) EXPECT_NEAR(normal_tail(z) / p, 1.0, 1e-12) << z;
}

TEST(NormalScore, IsTheInverseOfTheTail) {
  for (const double p : {0.5, 0.1, 0.025, 1e-3, 1e-9})
    EXPECT_NEAR(normal_tail(normal_score(p)) / p, 1.0, 1e-9) << p;
}

TEST(NormalTail, BothSidesAreEverything) {
  for (const double z : {0.1, 0.7, 2.3, 5.0})
    EXPECT_NEAR(normal_tail(z) + normal_tail(-z), 1.0, 1e-15);
}

TEST(ChiSquareTail, IsTheExactValueWithinTwoPercentWhereItDecides) {
  for (const int k : {4, 6, 10, 20, 50}) {
    for (double x = 0.3 * k; exact_chi_square_tail(x, k) > 0.01; x += 0.1 * k)
      EXPECT_NEAR(chi_square_tail(x, k) / exact_chi_square_tail(x, k), 1.0, 0.02) << k << ", " << x;
  }
}

TEST(BinomialTail, IsTheSumOfItsTerms) {
  EXPECT_EQ(binomial_tail(0, 5, 0.3), 1.0);
  EXPECT_NEAR(binomial_tail(3, 3, 0.5), 0.125, 1e-12);
  EXPECT_NEAR(binomial_tail(1, 4, 0.01), 1.0 - std::pow(0.99, 4), 1e-12);
  // from k or more upwards it is one less what lies below, seen from the other side
  EXPECT_NEAR(binomial_tail(7, 20, 0.4), 1.0 - binomial_tail(14, 20, 0.6), 1e-12);
  EXPECT_EQ(binomial_tail(2, 3, 0.0), 0.0);
  EXPECT_EQ(binomial_tail(2, 3, 1.0), 1.0);
}

TEST(ChiSquareTail, FallsFromOneAndGrowsWithTheDegrees) {
  EXPECT_EQ(chi_square_tail(0.0, 5), 1.0);
  EXPECT_EQ(chi_square_tail(-1.0, 5), 1.0);
  for (double x = 1.0; x < 40.0; x += 1.0) {
    EXPECT_GT(chi_square_tail(x, 5), chi_square_tail(x + 1.0, 5));
    EXPECT_LT(chi_square_tail(x, 5), chi_square_tail(x, 6));
  }
}

TEST(ChiSquareTail, OfASumOfSquaresIsUniform) {
  std::vector<double> p;
  for (std::uint64_t s = 0; s < 2000; ++s) {
    const std::vector<double> z = white(8, 100 + s);
    p.push_back(chi_square_tail(std::inner_product(z.begin(), z.end(), z.begin(), 0.0), 8));
  }
  for (const double level : {0.01, 0.05, 0.5, 0.95}) {
    const auto below = std::count_if(p.begin(), p.end(), [&](double v) { return v < level; });
    EXPECT_NEAR(static_cast<double>(below) / 2000, level,
                4.0 * std::sqrt(level * (1 - level) / 2000));
  }
}

/// q_i: the smallest share of false discoveries at which test i is among the discoveries.
double q_by_definition(const std::vector<double>& p, std::size_t i) {
  double best = 1.0;
  for (const double threshold : p) {
    if (threshold < p[i]) continue;
    const auto found = std::count_if(p.begin(), p.end(), [&](double v) { return v <= threshold; });
    best = std::min(best, threshold * static_cast<double>(p.size()) / static_cast<double>(found));
  }
  return best;
}

TEST(FalseDiscoveryRate, IsItsDefinition) {
  Random random(kSeed, 1);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<double> p(static_cast<std::size_t>(1 + random.below(25)));
    for (double& v : p) v = std::pow(random.uniform(), 3);
    const std::vector<double> q = false_discovery_rate(p);
    for (std::size_t i = 0; i < p.size(); ++i) EXPECT_NEAR(q[i], q_by_definition(p, i), 1e-14);
  }
}

TEST(FalseDiscoveryRate, OrdersAsTheEvidenceAndNeverFlatters) {
  std::vector<double> p;
  for (const double z : white(60, 2)) p.push_back(normal_tail(z));
  const std::vector<double> q = false_discovery_rate(p);
  for (std::size_t i = 0; i < p.size(); ++i) {
    EXPECT_GE(q[i], p[i]);
    for (std::size_t k = 0; k < p.size(); ++k) {
      if (p[i] < p[k]) {
        EXPECT_LE(q[i], q[k]);
      }
    }
  }
}

TEST(FalseDiscoveryRate, KeepsItsPromiseInAMixtureOfNullsAndEffects) {
  double false_share = 0.0;
  constexpr int kWorlds = 400;
  for (int w = 0; w < kWorlds; ++w) {
    std::vector<double> p;
    const std::vector<double> z = white(50, 5000 + static_cast<std::uint64_t>(w));
    for (std::size_t i = 0; i < z.size(); ++i) p.push_back(normal_tail(z[i] + (i < 10 ? 3.5 : 0)));
    const std::vector<double> q = false_discovery_rate(p);
    int found = 0, wrong = 0;
    for (std::size_t i = 0; i < q.size(); ++i) found += q[i] < 0.1, wrong += q[i] < 0.1 && i >= 10;
    false_share += found > 0 ? static_cast<double>(wrong) / found : 0.0;
  }
  EXPECT_LT(false_share / kWorlds, 0.1);
  EXPECT_GT(false_share / kWorlds, 0.05) << "0.08 = 0.1 times the share of nulls is expected";
}

/// Draws of independent |normal| statistics, the same for every call with one seed.
auto null_draws(std::uint64_t seed) {
  return [seed](int b, std::span<double> out) {
    Random random(seed, static_cast<std::uint64_t>(b));
    for (double& v : out) v = std::abs(random.normal());
  };
}

TEST(StepDownMaxT, OfOneTestIsThePlainMonteCarloP) {
  const std::vector<double> statistic{1.3};
  int reached = 0;
  std::vector<double> draw(1);
  for (int b = 0; b < 99; ++b) null_draws(3)(b, draw), reached += draw[0] >= statistic[0];
  EXPECT_DOUBLE_EQ(step_down_max_t(statistic, 99, null_draws(3))[0], (reached + 1) / 100.0);
}

TEST(StepDownMaxT, IsNeverBelowTheOwnPAndNeverBelowOneOverDraws) {
  const std::vector<double> statistic{0.2, 2.5, 1.0, 9.0, 2.4};
  const std::vector<double> p = step_down_max_t(statistic, 199, null_draws(4));
  for (std::size_t i = 0; i < p.size(); ++i) {
    EXPECT_GE(p[i], 1.0 / 200.0);
    EXPECT_LE(p[i], 1.0);
    EXPECT_GT(p[i], 2.0 * normal_tail(statistic[i]) - 0.1) << i;
  }
  EXPECT_DOUBLE_EQ(p[3], 1.0 / 200.0) << "nine deviations are never drawn";
}

TEST(StepDownMaxT, OrdersAsTheStatistics) {
  std::vector<double> statistic = white(20, 5);
  const std::vector<double> p = step_down_max_t(statistic, 99, null_draws(5));
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (std::size_t k = 0; k < p.size(); ++k) {
      if (statistic[i] > statistic[k]) {
        EXPECT_LE(p[i], p[k]);
      }
    }
  }
}

TEST(StepDownMaxT, ATestThatIsOutOfTheWayHelpsTheOthers) {
  // alone among nulls or beside a certain one: stepping down, the certain one costs nothing
  const std::vector<double> beside{50.0, 2.2}, alone{-INFINITY, 2.2};
  const double p_beside = step_down_max_t(beside, 499, null_draws(6))[1];
  int reached = 0;
  std::vector<double> draw(2);
  for (int b = 0; b < 499; ++b) null_draws(6)(b, draw), reached += draw[1] >= 2.2;
  EXPECT_DOUBLE_EQ(p_beside, (reached + 1) / 500.0);
  EXPECT_GT(step_down_max_t(alone, 499, null_draws(6))[1], p_beside);
}

TEST(WilsonInterval, EndsSolveTheScoreEquation) {
  // the end is the proportion from which the observed one is 1.96 deviations away
  for (const auto& [hits, trials] : {std::pair{1, 7}, {30, 100}, {499, 1000}, {19, 20}}) {
    const Interval i = wilson_interval(hits, trials);
    const double seen = static_cast<double>(hits) / trials;
    for (const double p : {i.low, i.high})
      EXPECT_NEAR(std::abs(seen - p) / std::sqrt(p * (1 - p) / trials), 1.959964, 1e-6);
  }
}

TEST(WilsonInterval, IsMirroredWhenFailuresAreCounted) {
  for (int hits = 0; hits <= 12; ++hits) {
    const Interval a = wilson_interval(hits, 12), b = wilson_interval(12 - hits, 12);
    EXPECT_NEAR(a.low, 1.0 - b.high, 1e-12);
    EXPECT_NEAR(a.high, 1.0 - b.low, 1e-12);
  }
}

TEST(WilsonInterval, CoversTheProportionAsOftenAsItSays) {
  // exact: sum of binomial probabilities whose interval holds p, averaged over p
  double covered = 0.0;
  int points = 0;
  for (double p = 0.025; p < 1.0; p += 0.025, ++points) {
    for (int k = 0; k <= 40; ++k) {
      const Interval i = wilson_interval(k, 40);
      if (p < i.low || p > i.high) continue;
      const double choose = std::lgamma(41) - std::lgamma(k + 1) - std::lgamma(41 - k);
      covered += std::exp(choose + k * std::log(p) + (40 - k) * std::log(1 - p));
    }
  }
  EXPECT_NEAR(covered / points, 0.95, 0.01);
}

TEST(WilsonInterval, OfNoTrialsIsEverything) {
  EXPECT_EQ(wilson_interval(0, 0).low, 0.0);
  EXPECT_EQ(wilson_interval(0, 0).high, 1.0);
}

TEST(MovingBlockBootstrap, BoundFollowsShiftAndScale) {
  const std::vector<double> x = coloured(150, 0.5, 7);
  const double bound = moving_block_lower_bound(x, 0.05, 400, Random(1));
  EXPECT_NEAR(moving_block_lower_bound(affine(x, 1.0, 2.0), 0.05, 400, Random(1)),
              bound + 2.0 * 150, 1e-9);
  EXPECT_NEAR(moving_block_lower_bound(affine(x, 4.0, 0.0), 0.05, 400, Random(1)), 4.0 * bound,
              1e-9);
}

TEST(MovingBlockBootstrap, AStricterLevelLiesLower) {
  const std::vector<double> x = coloured(150, 0.5, 8);
  double before = -INFINITY;
  for (const double level : {0.001, 0.01, 0.05, 0.2, 0.5}) {
    const double bound = moving_block_lower_bound(x, level, 999, Random(2));
    EXPECT_GT(bound, before) << level;
    before = bound;
  }
  EXPECT_LT(before, 150 * mean(x) + 0.2 * std::sqrt(150.0 * 4));
}

TEST(MovingBlockBootstrap, OfAConstantIsTheSumItself) {
  EXPECT_NEAR(moving_block_lower_bound(std::vector<double>(30, 0.7), 0.01, 200, Random(3)), 21.0,
              1e-12);
  EXPECT_EQ(moving_block_lower_bound(std::vector<double>{}, 0.01, 200, Random(3)), 0.0);
}

TEST(MovingBlockBootstrap, CoversTheTrueSumOfDependentGains) {
  // mean 0.5 a row: the bound may lie above the true sum as often as its level says
  int above = 0;
  for (std::uint64_t s = 0; s < 300; ++s) {
    const std::vector<double> x = affine(coloured(200, 0.6, 9000 + s), 1.0, 0.5);
    above += moving_block_lower_bound(x, 0.1, 199, Random(s)) > 0.5 * 200;
  }
  EXPECT_GT(above, 12);
  EXPECT_LT(above, 60) << "30 are expected";
}

TEST(StratifiedBootstrap, WhatDiffersBetweenStrataIsNoChance) {
  const std::vector<double> a = coloured(60, 0.3, 31), b = coloured(60, 0.3, 32);
  std::vector<std::vector<double>> strata{a, b};
  const double bound = stratified_lower_bound(strata, 0.05, 999, Random(6));
  EXPECT_LT(bound, 60 * (mean(a) + mean(b)));
  strata[1] = affine(b, 1.0, 50.0);
  EXPECT_NEAR(stratified_lower_bound(strata, 0.05, 999, Random(6)), bound + 50.0 * 60, 1e-6);
  // as one series a step of 50 is scatter
  std::vector<double> series = a;
  series.insert(series.end(), strata[1].begin(), strata[1].end());
  EXPECT_LT(moving_block_lower_bound(series, 0.05, 999, Random(6)), bound + 25.0 * 60);
}

TEST(StratifiedBootstrap, CoversTheTrueSumOfDependentGains) {
  int above = 0;
  for (std::uint64_t s = 0; s < 300; ++s) {
    std::vector<std::vector<double>> strata;
    for (std::uint64_t k = 0; k < 4; ++k)
      strata.push_back(affine(coloured(50, 0.4, 7000 + 4 * s + k), 1.0, static_cast<double>(k)));
    above += stratified_lower_bound(strata, 0.1, 199, Random(s)) > 50.0 * (0 + 1 + 2 + 3);
  }
  EXPECT_GT(above, 12);
  EXPECT_LT(above, 66) << "30 are expected";
}

}  // namespace
}  // namespace sanso::diagnose
