// The minimum under bounds is the minimum: against every active set of small problems.
#include "tools/diagnose/torque/bounded_least_squares.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>

#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double objective(const MatrixXd& G, const VectorXd& c, const VectorXd& x) {
  return 0.5 * x.dot(G * x) - c.dot(x);
}

/// Least objective over all ways to hold each of three unknowns low, high or not.
double by_enumeration(const MatrixXd& G, const VectorXd& c, const VectorXd& low,
                      const VectorXd& high) {
  double best = std::numeric_limits<double>::infinity();
  for (int code = 0; code < 27; ++code) {
    VectorXd x = VectorXd::Zero(3);
    MatrixXd K = MatrixXd::Identity(3, 3);
    VectorXd rhs(3);
    for (int i = 0, rest = code; i < 3; ++i, rest /= 3) {
      if (rest % 3 == 0) K.row(i) = G.row(i), rhs[i] = c[i];
      if (rest % 3 == 1) rhs[i] = low[i];
      if (rest % 3 == 2) rhs[i] = high[i];
    }
    x = K.fullPivLu().solve(rhs);
    if ((x - low).minCoeff() < -1e-9 || (high - x).minCoeff() < -1e-9) continue;
    best = std::min(best, objective(G, c, x));
  }
  return best;
}

TEST(BoundedLeastSquares, IsTheLeastOfAllActiveSets) {
  Random random(7);
  for (int trial = 0; trial < 200; ++trial) {
    MatrixXd A(6, 3);
    VectorXd y(6), low(3), high(3);
    for (int i = 0; i < A.size(); ++i) A.data()[i] = random.normal();
    for (int i = 0; i < 6; ++i) y[i] = 2.0 * random.normal();
    for (int i = 0; i < 3; ++i)
      low[i] = random.normal() - 0.5, high[i] = low[i] + random.uniform() + 0.05;
    const MatrixXd G = A.transpose() * A;
    const VectorXd c = A.transpose() * y;
    const VectorXd x = bounded_least_squares(G, c, low, high);
    EXPECT_GE((x - low).minCoeff(), -1e-12);
    EXPECT_GE((high - x).minCoeff(), -1e-12);
    EXPECT_NEAR(objective(G, c, x), by_enumeration(G, c, low, high), 1e-6) << trial;
  }
}

TEST(BoundedLeastSquares, LeavesAtZeroWhatNothingDetermines) {
  MatrixXd G = MatrixXd::Zero(2, 2);
  G(0, 0) = 4.0;
  const VectorXd inf = VectorXd::Constant(2, std::numeric_limits<double>::infinity());
  const VectorXd x = bounded_least_squares(G, Eigen::Vector2d(8.0, 0.0), -inf, inf);
  EXPECT_NEAR(x[0], 2.0, 1e-6);
  EXPECT_EQ(x[1], 0.0);
}

}  // namespace
}  // namespace sanso::diagnose
