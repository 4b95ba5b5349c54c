// Shape curves: every row is in one bin, levels stay together, bands and shares mean what they say.
#include "tools/diagnose/stats/curve.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/tools/diagnose/stats/made_series.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

using namespace test;

TEST(ShapeCurve, EveryRowIsInOneBinAndTheMeanIsKept) {
  for (std::uint64_t s = 0; s < 30; ++s) {
    const int n = 10 + 17 * static_cast<int>(s);
    const std::vector<double> x = white(n, s), y = white(n, 100 + s);
    const ShapeCurve curve = shape_curve(x, y, 12, 1.0);
    int rows = 0;
    double sum = 0.0;
    for (const CurvePoint& p : curve.points) rows += p.count, sum += p.count * p.mean;
    EXPECT_EQ(rows, n);
    EXPECT_NEAR(sum / n, mean(y), 1e-12);
  }
}

TEST(ShapeCurve, PointsAreInOrderAndHoldAtLeastFiveRows) {
  const ShapeCurve curve = shape_curve(white(333, 1), white(333, 2), 40, 1.0);
  for (std::size_t k = 0; k < curve.points.size(); ++k) {
    EXPECT_GE(curve.points[k].count, 5);
    if (k > 0) {
      EXPECT_GT(curve.points[k].x, curve.points[k - 1].x);
    }
  }
}

TEST(ShapeCurve, DoesNotSeeTheOrderOfTheRows) {
  const std::vector<double> x = white(100, 3), y = white(100, 4);
  const ShapeCurve a = shape_curve(x, y, 10, 1.0),
                   b = shape_curve(shuffled(x, 9), shuffled(y, 9), 10, 1.0);
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t k = 0; k < a.points.size(); ++k)
    EXPECT_NEAR(a.points[k].mean, b.points[k].mean, 1e-12);
}

TEST(ShapeCurve, LevelsOfAQuantisedQuantityStayTogether) {
  std::vector<double> x, y = white(400, 5);
  for (int i = 0; i < 400; ++i) x.push_back(i % 3);
  const ShapeCurve curve = shape_curve(x, y, 24, 1.0);
  ASSERT_EQ(curve.points.size(), 3u);
  for (int level = 0; level < 3; ++level)
    EXPECT_EQ(curve.points[static_cast<std::size_t>(level)].x, level);
}

TEST(ShapeCurve, EmptyCellsAreLeftOut) {
  std::vector<double> x = white(50, 6), y = white(50, 7);
  const ShapeCurve before = shape_curve(x, y, 5, 1.0);
  x.push_back(NAN), y.push_back(1e9);
  x.push_back(0.0), y.push_back(NAN);
  const ShapeCurve after = shape_curve(x, y, 5, 1.0);
  ASSERT_EQ(before.points.size(), after.points.size());
  EXPECT_EQ(before.points[2].mean, after.points[2].mean);
  EXPECT_TRUE(shape_curve(white(9, 8), white(9, 9), 5, 1.0).points.empty());
}

TEST(ShapeCurve, ExplainsAllOfALawAndNothingOfNoise) {
  const std::vector<double> x = white(4000, 10);
  std::vector<double> step;
  for (const double v : x) step.push_back(v > 0 ? 1.0 : -1.0);
  EXPECT_GT(shape_curve(x, step, 24, 1.0).explained, 0.9);
  EXPECT_LT(shape_curve(x, white(4000, 11), 24, 1.0).explained, 0.02);
  EXPECT_EQ(shape_curve(x, std::vector<double>(4000, 2.0), 24, 1.0).explained, 0.0);
}

TEST(ShapeCurve, BandsHoldTheLawAndWidenWithDependence) {
  const std::vector<double> x = white(6000, 12), noise = white(6000, 13);
  std::vector<double> y;
  for (std::size_t i = 0; i < x.size(); ++i) y.push_back(0.3 * x[i] + noise[i]);
  const ShapeCurve curve = shape_curve(x, y, 24, 1.0), wide = shape_curve(x, y, 24, 9.0);
  int inside = 0;
  for (std::size_t k = 0; k < curve.points.size(); ++k) {
    const CurvePoint& p = curve.points[k];
    inside += std::abs(p.mean - 0.3 * p.x) < 2.0 * p.error;
    EXPECT_NEAR(wide.points[k].error, 3.0 * p.error, 1e-12);
  }
  EXPECT_GE(inside, 20) << "of " << curve.points.size();
}

}  // namespace
}  // namespace sanso::diagnose
