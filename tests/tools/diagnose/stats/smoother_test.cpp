// The smoother against the dense Gaussian posterior of the same model, polynomials and symmetries.
#include "tools/diagnose/stats/smoother.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/tools/diagnose/stats/made_series.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

using namespace test;

/// Uneven instants about `step` apart.
std::vector<double> instants(int n, double step, std::uint64_t stream) {
  Random random(kSeed, stream);
  std::vector<double> t{0.0};
  while (static_cast<int>(t.size()) < n) t.push_back(t.back() + step * (0.5 + random.uniform()));
  return t;
}

struct Posterior {
  Eigen::VectorXd x;  // q, dq, ddq by row
  Eigen::MatrixXd covariance;
};

/// All states at once by weighted least squares: jerk of density s between rows, positions
/// measured, nothing known before the first row.
Posterior dense_posterior(const std::vector<double>& t, const std::vector<double>& q, double sigma,
                          double s) {
  const auto n = static_cast<Eigen::Index>(t.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(3 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double measured = q[static_cast<std::size_t>(k)];
    if (std::isfinite(measured)) {
      information(3 * k, 3 * k) += 1.0 / (sigma * sigma);
      right(3 * k) += measured / (sigma * sigma);
    }
    if (k == 0) continue;
    const double h = t[static_cast<std::size_t>(k)] - t[static_cast<std::size_t>(k - 1)];
    Eigen::MatrixXd step(3, 6);  // x_k - F x_{k-1}
    step << -1, -h, -h * h / 2, 1, 0, 0, 0, -1, -h, 0, 1, 0, 0, 0, -1, 0, 0, 1;
    Eigen::Matrix3d Q;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {  // integral of u^(2-i) u^(2-j) / ((2-i)! (2-j)!)
        const int a = 2 - i, b = 2 - j;
        Q(i, j) =
            s * std::pow(h, a + b + 1) / ((a + b + 1) * std::tgamma(a + 1) * std::tgamma(b + 1));
      }
    }
    information.block(3 * k - 3, 3 * k - 3, 6, 6) += step.transpose() * Q.inverse() * step;
  }
  const Eigen::MatrixXd covariance = information.inverse();
  return {covariance * right, covariance};
}

TEST(Smoother, IsThePosteriorOfItsModel) {
  const std::vector<double> t = instants(40, 0.1, 1), noise = white(40, 2);
  std::vector<double> q;
  for (std::size_t k = 0; k < t.size(); ++k) q.push_back(std::sin(2 * t[k]) + 0.01 * noise[k]);
  q[17] = q[18] = NAN;
  const SmoothedState s = smooth_position(t, q, 0.01);
  const Posterior exact = dense_posterior(t, q, 0.01, s.jerk_density);
  // the filter's start is proper and wide: its trace is gone after two rows
  for (std::size_t k = 2; k < t.size(); ++k) {
    const auto at = static_cast<Eigen::Index>(3 * k);
    EXPECT_NEAR(s.q[k], exact.x(at), 1e-5) << k;
    EXPECT_NEAR(s.dq[k], exact.x(at + 1), 1e-4) << k;
    EXPECT_NEAR(s.ddq[k], exact.x(at + 2), 1e-2) << k;
    EXPECT_NEAR(s.q_sigma[k] / std::sqrt(exact.covariance(at, at)), 1.0, 1e-3) << k;
    EXPECT_NEAR(s.dq_sigma[k] / std::sqrt(exact.covariance(at + 1, at + 1)), 1.0, 1e-3) << k;
  }
}

TEST(Smoother, CountsTheFirstReadingOnce) {
  const SmoothedState one = smooth_position(std::vector{0.0}, std::vector{0.7}, 0.01);
  EXPECT_NEAR(one.q[0], 0.7, 1e-12);
  EXPECT_NEAR(one.q_sigma[0], 0.01, 1e-6) << "one reading says what one reading says";
}

TEST(Smoother, ReproducesAParabolaWithItsDerivatives) {
  const std::vector<double> t = instants(200, 0.01, 3);
  std::vector<double> q;
  for (const double x : t) q.push_back(0.3 - 0.5 * x + 0.7 * x * x);
  const SmoothedState s = smooth_position(t, q, 1e-4);
  // the two rows before cost the wide start of the filter its digits
  for (std::size_t k = 2; k < t.size(); ++k) {
    EXPECT_NEAR(s.q[k], q[k], 1e-5);
    EXPECT_NEAR(s.dq[k], -0.5 + 1.4 * t[k], 1e-3);
    EXPECT_NEAR(s.ddq[k], 1.4, 0.02);
  }
}

TEST(Smoother, DoesNotCareWhenTheClockWasStarted) {
  const std::vector<double> t = instants(100, 0.02, 4), q = coloured(100, 0.99, 4);
  const SmoothedState a = smooth_position(t, q, 0.1);
  const SmoothedState b = smooth_position(affine(t, 1.0, 64.0), q, 0.1);
  EXPECT_EQ(a.jerk_density, b.jerk_density);
  for (std::size_t k = 0; k < t.size(); ++k) EXPECT_NEAR(a.dq[k], b.dq[k], 1e-7);
}

TEST(Smoother, DoesNotCareWhereZeroIs) {
  const std::vector<double> t = instants(100, 0.02, 5), q = coloured(100, 0.99, 5);
  const SmoothedState a = smooth_position(t, q, 0.1),
                      b = smooth_position(t, affine(q, 1.0, 8.0), 0.1);
  for (std::size_t k = 0; k < t.size(); ++k) {
    EXPECT_NEAR(b.q[k], a.q[k] + 8.0, 1e-9);
    EXPECT_NEAR(b.dq[k], a.dq[k], 1e-7);
  }
}

TEST(Smoother, AMirroredMotionHasMirroredVelocities) {
  const std::vector<double> t = instants(100, 0.02, 6), q = coloured(100, 0.99, 6);
  const SmoothedState a = smooth_position(t, q, 0.1),
                      b = smooth_position(t, affine(q, -1.0, 0.0), 0.1);
  for (std::size_t k = 0; k < t.size(); ++k) {
    EXPECT_EQ(b.q[k], -a.q[k]);
    EXPECT_EQ(b.dq[k], -a.dq[k]);
    EXPECT_EQ(b.ddq[k], -a.ddq[k]);
    EXPECT_EQ(b.dq_sigma[k], a.dq_sigma[k]);
  }
}

TEST(Smoother, AMotionPlayedBackwardsHasTheSpeedsTurned) {
  std::vector<double> t, q;
  for (int k = 0; k < 300; ++k) t.push_back(0.01 * k), q.push_back(0.4 * std::sin(5 * t.back()));
  const std::vector<double> backwards(q.rbegin(), q.rend());
  const SmoothedState a = smooth_position(t, q, 1e-3), b = smooth_position(t, backwards, 1e-3);
  for (std::size_t k = 30; k + 30 < t.size(); ++k) {
    EXPECT_NEAR(b.dq[t.size() - 1 - k], -a.dq[k], 5e-3);
    EXPECT_NEAR(b.ddq[t.size() - 1 - k], a.ddq[k], 0.2);
  }
}

TEST(Smoother, KnowsTheFirstVelocityAsWellAsTheLast) {
  // nothing is known before the first row and nothing after the last: a shot starts at either
  for (const double sigma : {1e-4, 3e-4, 1e-3}) {
    for (const double step : {0.002, 0.01, 0.02}) {
      const std::vector<double> noise = white(300, 8);
      std::vector<double> t, q;
      for (std::size_t k = 0; k < noise.size(); ++k) {
        t.push_back(step * static_cast<double>(k));
        q.push_back(0.4 * std::sin(5 * t.back()) + sigma * noise[k]);
      }
      const SmoothedState s = smooth_position(t, q, sigma);
      for (std::size_t k = 0; k < 4; ++k)
        EXPECT_NEAR(s.dq_sigma[k] / s.dq_sigma[t.size() - 1 - k], 1.0, 0.3)
            << "row " << k << ", noise " << sigma << ", step " << step;
    }
  }
}

TEST(Smoother, KnowsLessInAGap) {
  const std::vector<double> t = instants(120, 0.02, 7);
  std::vector<double> q;
  for (const double x : t) q.push_back(std::sin(3 * x));
  for (std::size_t k = 50; k < 60; ++k) q[k] = NAN;
  const SmoothedState s = smooth_position(t, q, 1e-3);
  EXPECT_GT(s.q_sigma[55], 3.0 * s.q_sigma[30]);
  EXPECT_NEAR(s.q[55], std::sin(3 * t[55]), 3.0 * s.q_sigma[55]);
}

TEST(Smoother, ASampleWithoutWeightIsNoSample) {
  const std::vector<double> t = instants(80, 0.02, 8);
  std::vector<double> q = coloured(80, 0.99, 8), empty = q, sigma(80, 0.1);
  q[40] = 1000.0, sigma[40] = 1e9, empty[40] = NAN;
  const SmoothedState with = smooth_position(t, q, sigma),
                      without = smooth_position(t, empty, std::vector<double>(80, 0.1));
  ASSERT_EQ(with.jerk_density, without.jerk_density);
  for (std::size_t k = 0; k < t.size(); ++k) EXPECT_NEAR(with.q[k], without.q[k], 1e-6);
}

TEST(Smoother, BandsHoldTheTruthAsOftenAsTheySay) {
  int inside = 0, all = 0;
  for (std::uint64_t s = 0; s < 10; ++s) {
    const std::vector<double> t = instants(300, 0.01, 20 + s), noise = white(300, 40 + s);
    std::vector<double> q;
    for (std::size_t k = 0; k < t.size(); ++k) q.push_back(std::sin(4 * t[k]) + 2e-3 * noise[k]);
    const SmoothedState out = smooth_position(t, q, 2e-3);
    for (std::size_t k = 5; k + 5 < t.size(); ++k, ++all)
      inside += std::abs(out.q[k] - std::sin(4 * t[k])) < 2.0 * out.q_sigma[k];
  }
  EXPECT_GT(static_cast<double>(inside) / all, 0.9);
}

TEST(Smoother, OfNothingIsNothing) {
  EXPECT_TRUE(smooth_position(std::vector<double>{}, std::vector<double>{}, 0.1).q.empty());
}

TEST(Smoother, WhatItSupposesBeforeTheFirstReadingIsForgottenWhenItIsWide) {
  const std::vector<double> t = instants(200, 0.01, 3), noise = white(200, 4);
  std::vector<double> q;
  for (std::size_t k = 0; k < t.size(); ++k) q.push_back(20.0 * t[k] + 1e-3 * noise[k]);
  SmootherSettings wider, narrow;
  wider.position *= 2.0, wider.speed *= 2.0, wider.acceleration *= 2.0;
  narrow.speed = 0.01;
  const SmoothedState as_is = smooth_position(t, q, 1e-3),
                      wide = smooth_position(t, q, 1e-3, wider),
                      at_rest = smooth_position(t, q, 1e-3, narrow);
  ASSERT_EQ(as_is.jerk_density, wide.jerk_density);
  for (std::size_t k = 0; k < t.size(); ++k) {
    EXPECT_NEAR(as_is.q[k], wide.q[k], 0.02 * as_is.q_sigma[k]) << k;
    EXPECT_NEAR(as_is.dq[k], wide.dq[k], 0.02 * as_is.dq_sigma[k]) << k;
  }
  EXPECT_LT(at_rest.dq[0], 0.5 * as_is.dq[0]) << "a body said to be at rest begins slowly";
}

}  // namespace
}  // namespace sanso::diagnose
