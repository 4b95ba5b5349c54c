// Sums of probes against what two correlated scores explain in closed form.
#include "tools/diagnose/fit/probe_sums.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sanso::diagnose {
namespace {

/// A candidate of two sizes and an order, and a screening of its two axes at these orders.
struct TwoAxes {
  TwoAxes(double za, double zb, double correlation, double order_a, double order_b) {
    Candidate c;
    c.parameters.resize(3);
    c.parameters[2].structural = true;
    c.probes = {{1.0, 0.0, order_a}, {0.0, 1.0, order_b}};
    library.candidates = {c};
    screening.probes = {{0, 0}, {0, 1}};
    screening.correlation = Eigen::Matrix2d{{1.0, correlation}, {correlation, 1.0}};
    const double z[] = {za, zb};
    for (std::size_t i = 0; i < 2; ++i) {
      screening.probes[i].z = z[i];
      screening.probes[i].score = std::abs(z[i]);
      screening.probes[i].signature = 1.0;
    }
  }
  double together(std::size_t probe) const {
    return with_sums(DecisionSettings{}, library, screening).probes[probe].together;
  }
  Library library;
  Screening screening;
};

TEST(ProbeSums, AreWhatBothAxesExplainLessChance) {
  for (const double r : {0.0, 0.5, -0.8}) {
    const double a = 6.0, b = -3.0;
    const double square = (a * a - 2.0 * r * a * b + b * b) / (1.0 - r * r);
    const TwoAxes two(a, b, r, 1.0, 1.0);
    EXPECT_NEAR(two.together(0), std::sqrt(std::max(square - 1.0, a * a)), 1e-9) << r;
    EXPECT_NEAR(two.together(1), std::sqrt(std::max(square - 1.0, b * b)), 1e-9) << r;
  }
}

TEST(ProbeSums, ProbesThatAreOneDirectionExplainNoMore) {
  const TwoAxes alike(5.0, 5.0, 0.9999, 1.0, 1.0);
  EXPECT_NEAR(alike.together(0), 5.0, 0.01);
}

TEST(ProbeSums, OtherOrdersAndOneSidedNamesStandAlone) {
  const TwoAxes orders(6.0, 3.0, 0.0, 1.0, 2.0);
  EXPECT_EQ(orders.together(0), 6.0);
  EXPECT_EQ(orders.together(1), 3.0);
  TwoAxes one_sided(6.0, 3.0, 0.0, 1.0, 1.0);
  one_sided.library.candidates[0].two_sided = false;
  EXPECT_EQ(one_sided.together(0), 6.0);
}

}  // namespace
}  // namespace sanso::diagnose
