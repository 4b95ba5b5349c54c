// Quantiles against sorting, and against each other where their definitions meet.
#include "shared/math/order_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "shared/math/splitmix.h"

namespace sanso::math {
namespace {

std::vector<double> shuffled(std::size_t n) {
  std::vector<double> values(n);
  for (std::size_t i = 0; i < n; ++i)
    values[i] = static_cast<double>(splitmix(i + 100 * n) % 50) - 25.0;  // with ties
  return values;
}

TEST(OrderStatistics, RankIsThePlaceAfterSorting) {
  for (const std::size_t n : {1u, 2u, 7u, 100u}) {
    std::vector<double> sorted = shuffled(n);
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t k = 0; k < n; ++k) {
      std::vector<double> values = shuffled(n);
      EXPECT_EQ(value_of_rank(std::span(values), k), sorted[k]);
      EXPECT_TRUE(std::all_of(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(k),
                              [&](double v) { return v <= sorted[k]; }));
    }
  }
}

TEST(OrderStatistics, EndsAreSmallestAndLargestInEveryMeaning) {
  std::vector<double> values{3, 1, 2, 5, 4};
  for (const auto& [p, expected] : {std::pair(0.0, 1.0), std::pair(1.0, 5.0)}) {
    EXPECT_EQ(quantile_linear(values, p), expected);
    EXPECT_EQ(quantile_below(std::span(values), p), expected);
    EXPECT_EQ(quantile_nearest(std::span(values), p), expected);
  }
}

TEST(OrderStatistics, TheThreeMeaningsOfOneQuantile) {
  std::vector<double> values{40, 10, 30, 20};  // rank 0.6 * 3 = 1.8; 0.6 * 4 = 2.4
  EXPECT_DOUBLE_EQ(quantile_linear(values, 0.6), 28.0);
  EXPECT_EQ(quantile_below(std::span(values), 0.6), 20.0);
  EXPECT_EQ(quantile_nearest(std::span(values), 0.6), 30.0);
  EXPECT_DOUBLE_EQ(quantile_linear(values, 0.5), 25.0);
  EXPECT_EQ(quantile_nearest(std::span(values), 0.5), 20.0) << "half of them do not exceed it";
}

TEST(OrderStatistics, OneValueIsEveryQuantile) {
  std::vector<float> values{2.5f};
  for (const double p : {0.0, 0.3, 1.0}) EXPECT_EQ(quantile_nearest(std::span(values), p), 2.5f);
}

}  // namespace
}  // namespace sanso::math
