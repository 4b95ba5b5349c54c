// Properties of series: positive definiteness, invariances, known processes.
#include "tools/diagnose/stats/series.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "tests/tools/diagnose/stats/made_series.h"
#include "tools/diagnose/stats/robust.h"

namespace sanso::diagnose {
namespace {

using namespace test;

TEST(Autocorrelation, StartsAtOneAndStaysWithin) {
  const std::vector<double> rho = autocorrelation(coloured(300, 0.7, 1), 40);
  ASSERT_EQ(rho.size(), 41u);
  EXPECT_DOUBLE_EQ(rho[0], 1.0);
  for (const double r : rho) EXPECT_LE(std::abs(r), 1.0);
}

TEST(Autocorrelation, ForgetsUnitOffsetAndDirectionOfTime) {
  const std::vector<double> x = coloured(200, 0.8, 2);
  std::vector<double> reversed(x.rbegin(), x.rend());
  const std::vector<double> rho = autocorrelation(x, 20),
                            other = autocorrelation(affine(x, -4.0, 30.0), 20),
                            back = autocorrelation(reversed, 20);
  for (std::size_t k = 0; k < rho.size(); ++k) {
    EXPECT_NEAR(other[k], rho[k], 1e-12);
    EXPECT_NEAR(back[k], rho[k], 1e-12);
  }
}

TEST(Autocorrelation, IsPositiveDefinite) {
  const std::vector<double> rho = autocorrelation(coloured(80, 0.95, 3), 30);
  Eigen::MatrixXd toeplitz(31, 31);
  for (int i = 0; i < 31; ++i) {
    for (int j = 0; j < 31; ++j) toeplitz(i, j) = rho[static_cast<std::size_t>(std::abs(i - j))];
  }
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(toeplitz).eigenvalues().minCoeff(), 0.0);
}

TEST(Autocorrelation, OfASignThatAlternatesIsMinusOneLessTheEnd) {
  std::vector<double> x;
  for (int i = 0; i < 100; ++i) x.push_back(i % 2 == 0 ? 1.0 : -1.0);
  EXPECT_NEAR(autocorrelation(x, 1)[1], -0.99, 1e-12);
}

TEST(Autocorrelation, OfAConstantIsNothing) {
  for (const double r : autocorrelation(std::vector<double>(20, 3.0), 5)) EXPECT_EQ(r, 0.0);
}

TEST(AutocorrelationTime, IsAtLeastOneAndOneWhereThereIsTooLittle) {
  std::vector<double> alternating;
  for (int i = 0; i < 400; ++i) alternating.push_back(i % 2 == 0 ? 1.0 : -1.0);
  EXPECT_EQ(autocorrelation_time(alternating), 1.0);
  EXPECT_EQ(autocorrelation_time(coloured(7, 0.9, 4)), 1.0);
}

TEST(AutocorrelationTime, OfEveryValueRepeatedIsTheNumberOfRepeats) {
  for (const std::size_t repeats : {2u, 5u, 10u}) {
    std::vector<double> time;
    for (std::uint64_t s = 0; s < 20; ++s) {
      std::vector<double> x;
      for (const double v : white(2000, 5000 + s)) x.insert(x.end(), repeats, v);
      time.push_back(autocorrelation_time(x));
    }
    const auto expected = static_cast<double>(repeats);
    EXPECT_NEAR(median(time), expected, 0.1 * expected);
  }
}

TEST(AutocorrelationTime, PredictsHowMuchAMeanScatters) {
  // variance of the mean of n rows = time / n * variance of a row
  std::vector<double> means;
  double time = 0.0;
  for (std::uint64_t s = 0; s < 300; ++s) {
    const std::vector<double> x = coloured(1000, 0.6, 100 + s);
    means.push_back(mean(x));
    time += autocorrelation_time(x) / 300;
  }
  const double row = 1.0 / (1.0 - 0.36);
  EXPECT_NEAR(std::pow(standard_deviation(means), 2), time / 1000 * row, 0.25 * time / 1000 * row);
}

TEST(AutocorrelationTime, ForgetsUnitAndOffset) {
  const std::vector<double> x = coloured(500, 0.7, 6);
  EXPECT_NEAR(autocorrelation_time(affine(x, 1e-3, 5.0)), autocorrelation_time(x), 1e-9);
}

/// Response of the fitted model to one unit of innovation.
std::vector<double> impulse_response(const Autoregression& model, int n) {
  std::vector<double> h{1.0};
  while (static_cast<int>(h.size()) < n) {
    double next = 0.0;
    for (std::size_t i = 0; i < model.coefficients.size() && i < h.size(); ++i)
      next += model.coefficients[i] * h[h.size() - 1 - i];
    h.push_back(next);
  }
  return h;
}

TEST(Autoregression, IsStableWhateverItIsFittedTo) {
  for (std::uint64_t s = 0; s < 60; ++s) {
    std::vector<double> x = coloured(60, 1.02, 400 + s);  // a walk that runs away
    const std::vector<double> h = impulse_response(fit_autoregression(x, 5), 40000);
    const auto end = std::span(h).last(50);
    EXPECT_LT(*std::max_element(end.begin(), end.end()), 1.0) << "stream " << 400 + s;
  }
}

TEST(Autoregression, FindsASecondOrderProcess) {
  std::vector<double> x = white(30000, 7);
  for (std::size_t i = 2; i < x.size(); ++i) x[i] += 1.2 * x[i - 1] - 0.5 * x[i - 2];
  const Autoregression model = fit_autoregression(affine(x, 3.0, 8.0), 3);
  EXPECT_NEAR(model.coefficients[0], 1.2, 0.03);
  EXPECT_NEAR(model.coefficients[1], -0.5, 0.03);
  EXPECT_NEAR(model.coefficients[2], 0.0, 0.03);
  EXPECT_NEAR(model.innovation_sigma, 3.0, 0.06);
}

TEST(Autoregression, LeavesNothingToPredict) {
  const std::vector<double> x = coloured(5000, 0.9, 8);
  const Autoregression model = fit_autoregression(x, 2);
  std::vector<double> left;
  for (std::size_t i = 2; i < x.size(); ++i)
    left.push_back(x[i] - model.coefficients[0] * x[i - 1] - model.coefficients[1] * x[i - 2]);
  EXPECT_NEAR(autocorrelation(left, 1)[1], 0.0, 3.0 / std::sqrt(5000.0));
  EXPECT_NEAR(standard_deviation(left), model.innovation_sigma, 0.02);
}

TEST(Autoregression, AlwaysHasAsManyCoefficientsAsWereAsked) {
  EXPECT_EQ(fit_autoregression(std::vector<double>{1, 2}, 4).coefficients.size(), 4u);
  EXPECT_EQ(fit_autoregression(std::vector<double>(50, 2.0), 4).innovation_sigma, 0.0);
  EXPECT_NEAR(fit_autoregression(white(4000, 9), 0).innovation_sigma, 1.0, 0.03);
}

}  // namespace
}  // namespace sanso::diagnose
