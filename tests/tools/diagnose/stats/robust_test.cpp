// Order statistics and robust scale: definition, equivariance, breakdown.
#include "tools/diagnose/stats/robust.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/tools/diagnose/stats/made_series.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// The definition, on a sorted copy: linear between the order statistics around p (n - 1).
double quantile_by_definition(std::vector<double> x, double p) {
  std::erase_if(x, [](double v) { return !std::isfinite(v); });
  std::sort(x.begin(), x.end());
  const double rank = p * static_cast<double>(x.size() - 1);
  const auto low = static_cast<std::size_t>(std::floor(rank));
  const auto high = static_cast<std::size_t>(std::ceil(rank));
  return x[low] + (rank - std::floor(rank)) * (x[high] - x[low]);
}

TEST(Quantile, IsItsDefinitionOnAnyDataWithHoles) {
  Random random(kSeed, 1);
  for (std::uint64_t s = 0; s < 200; ++s) {
    std::vector<double> x = with_holes(white(1 + random.below(40), 10 + s), 0.2, 500 + s);
    x.push_back(random.normal());  // never without a value
    const double p = random.uniform();
    EXPECT_NEAR(quantile(x, p), quantile_by_definition(x, p), 1e-13) << "stream " << s;
  }
}

TEST(Quantile, EndsAreTheExtremesAndBeyondThemNothingIsAdded) {
  const std::vector<double> x = white(101, 2);
  const auto [low, high] = std::minmax_element(x.begin(), x.end());
  EXPECT_EQ(quantile(x, 0.0), *low);
  EXPECT_EQ(quantile(x, 1.0), *high);
  EXPECT_EQ(quantile(x, -0.5), *low);
  EXPECT_EQ(quantile(x, 1.5), *high);
}

TEST(Quantile, GrowsWithItsShare) {
  const std::vector<double> x = white(37, 3);
  double before = -INFINITY;
  for (double p = 0.0; p <= 1.0; p += 0.01) {
    EXPECT_GE(quantile(x, p), before) << p;
    before = quantile(x, p);
  }
}

TEST(Quantile, FollowsShiftScaleAndMirror) {
  const std::vector<double> x = white(58, 4);
  for (const double p : {0.0, 0.1, 0.37, 0.5, 0.9}) {
    EXPECT_NEAR(quantile(affine(x, 3.0, -7.0), p), 3.0 * quantile(x, p) - 7.0, 1e-13);
    EXPECT_NEAR(quantile(affine(x, -1.0, 0.0), p), -quantile(x, 1.0 - p), 1e-13);
  }
}

TEST(Quantile, DoesNotSeeTheOrderOfTheRows) {
  const std::vector<double> x = white(75, 5);
  for (std::uint64_t s = 0; s < 20; ++s) {
    const std::vector<double> other = shuffled(x, 40 + s);
    EXPECT_EQ(quantile(other, 0.3), quantile(x, 0.3));
    EXPECT_EQ(robust_sigma(other), robust_sigma(x));
  }
}

TEST(Quantile, OfNothingIsNothing) {
  EXPECT_TRUE(std::isnan(quantile(std::vector<double>{}, 0.5)));
  EXPECT_TRUE(std::isnan(quantile(std::vector<double>{NAN, INFINITY}, 0.5)));
  EXPECT_EQ(quantile(std::vector<double>{NAN, 2.5}, 0.9), 2.5);
}

TEST(FiniteValues, KeepTheirOrderAndLoseNoNumber) {
  const std::vector<double> x{3, NAN, -1, INFINITY, 2, -INFINITY};
  EXPECT_EQ(finite_values(x), (std::vector<double>{3, -1, 2}));
}

TEST(RobustSigma, IsTheDeviationOfNormalData) {
  for (const double sigma : {1e-6, 1.0, 2e4})
    EXPECT_NEAR(robust_sigma(affine(white(40000, 6), sigma, 5.0)), sigma, 0.02 * sigma);
}

TEST(RobustSigma, ScalesWithoutSignAndForgetsTheShift) {
  const std::vector<double> x = white(200, 7);
  EXPECT_NEAR(robust_sigma(affine(x, -3.0, 100.0)), 3.0 * robust_sigma(x), 1e-11);
}

TEST(RobustSigma, StaysFiniteUntilHalfOfTheRowsAreWrong) {
  std::vector<double> x = white(1000, 8);
  for (std::size_t i = 0; i < 490; ++i) x[i] = 1e9;
  EXPECT_LT(robust_sigma(x), 50.0);
  EXPECT_GT(standard_deviation(x), 1e8) << "the plain deviation would not tell";
}

TEST(RobustSigma, OfAConstantIsZeroAndOfNothingToo) {
  EXPECT_EQ(robust_sigma(std::vector<double>(9, 4.0)), 0.0);
  EXPECT_EQ(robust_sigma(std::vector<double>{NAN}), 0.0);
}

TEST(Mean, SquareOfRmsIsSquareOfMeanPlusVariance) {
  for (std::uint64_t s = 0; s < 20; ++s) {
    const std::vector<double> x = with_holes(affine(white(50, 60 + s), 2.0, 3.0), 0.1, 90 + s);
    const auto n = static_cast<double>(finite_values(x).size());
    const double variance = std::pow(standard_deviation(x), 2) * (n - 1) / n;
    EXPECT_NEAR(std::pow(rms(x), 2), std::pow(mean(x), 2) + variance, 1e-11);
  }
}

TEST(StandardDeviation, KeepsItsDigitsUnderALargeOffset) {
  const std::vector<double> x = white(500, 9);
  EXPECT_NEAR(standard_deviation(affine(x, 1.0, 1e8)), standard_deviation(x), 1e-7);
}

TEST(StandardDeviation, OfTwoValuesIsTheirDistanceOverRootTwo) {
  EXPECT_DOUBLE_EQ(standard_deviation(std::vector<double>{1, NAN, 4}), 3.0 / std::sqrt(2.0));
  EXPECT_EQ(standard_deviation(std::vector<double>{4}), 0.0);
}

TEST(Correlation, OfALineIsItsSign) {
  const std::vector<double> x = white(30, 10);
  EXPECT_NEAR(correlation(x, affine(x, 0.2, 9.0)), 1.0, 1e-12);
  EXPECT_NEAR(correlation(x, affine(x, -5.0, 1.0)), -1.0, 1e-12);
}

TEST(Correlation, IsSymmetricAndForgetsUnitsAndOffsets) {
  const std::vector<double> x = white(80, 11), y = coloured(80, 0.5, 11);
  const double c = correlation(x, y);
  EXPECT_NEAR(correlation(y, x), c, 1e-13);
  EXPECT_NEAR(correlation(affine(x, 57.3, 0.0), affine(y, 1e-3, 1e6)), c, 1e-6);
  EXPECT_LT(std::abs(c), 1.0);
}

TEST(Correlation, OfIndependentSeriesIsOneOverRootN) {
  int large = 0;
  for (std::uint64_t s = 0; s < 200; ++s)
    large += std::abs(correlation(white(400, 1000 + s), white(400, 2000 + s))) > 2.0 / 20.0;
  EXPECT_LT(large, 25) << "5 % of 200 are expected";
}

TEST(Correlation, LeavesRowsOutWhereEitherSideIsEmpty) {
  std::vector<double> x = white(60, 12), y = coloured(60, 0.3, 12);
  const double before = correlation(x, y);
  for (int k = 0; k < 5; ++k) {
    x.push_back(NAN), y.push_back(1e6);
    x.push_back(-1e6), y.push_back(NAN);
  }
  EXPECT_EQ(correlation(x, y), before);
}

TEST(Correlation, IsZeroWhereThereIsNothingToCompare) {
  EXPECT_EQ(correlation(std::vector<double>(9, 2.0), white(9, 13)), 0.0);
  EXPECT_EQ(correlation(std::vector<double>{1, 2}, std::vector<double>{1, 2}), 0.0);
  EXPECT_EQ(correlation(std::vector<double>{1, 2, NAN}, std::vector<double>{1, 2, 3}), 0.0);
}

}  // namespace
}  // namespace sanso::diagnose
