// Two effects proposed together: their promise is the least squares of two regressors, and what is
// one effect, a special case, or chance is proposed as none.
#include "tools/diagnose/fit/pairs.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose {
namespace {

constexpr double kAlike = 0.995;

TEST(PromiseTogether, IsWhatLeastSquaresOfBothRemoves) {
  Random random(7);
  for (int trial = 0; trial < 50; ++trial) {
    Eigen::MatrixXd s(30, 2);
    Eigen::VectorXd r(30);
    for (Eigen::Index k = 0; k < 30; ++k) {
      const double common = random.normal();
      s(k, 0) = common + random.normal(), s(k, 1) = common + 0.5 * random.normal();
      r[k] = random.normal() + 2.0 * common;
    }
    s.col(0).normalize(), s.col(1).normalize();
    const Eigen::VectorXd amounts = s.colPivHouseholderQr().solve(r);
    const double removed = r.squaredNorm() - (r - s * amounts).squaredNorm();
    const TogetherPromise both = promise_together(s.col(0).dot(r), s.col(1).dot(r),
                                                  s.col(0).dot(s.col(1)), false, false, kAlike);
    EXPECT_NEAR(both.energy, removed, 1e-9 * removed);
    EXPECT_NEAR(both.a, amounts[0], 1e-9);
    EXPECT_NEAR(both.b, amounts[1], 1e-9);
    // never less than the stronger one alone, and the same for the pair turned round
    EXPECT_GE(both.energy,
              std::pow(std::max(std::abs(s.col(0).dot(r)), std::abs(s.col(1).dot(r))), 2) - 1e-9);
    const TogetherPromise turned = promise_together(s.col(1).dot(r), s.col(0).dot(r),
                                                    s.col(0).dot(s.col(1)), false, false, kAlike);
    EXPECT_NEAR(both.energy, turned.energy, 1e-9 * removed);
  }
}

TEST(PromiseTogether, IsNothingWhereOneWouldHaveToBeNegativeOrBothAreOne) {
  EXPECT_GT(promise_together(5.0, 4.0, 0.95, false, false, kAlike).energy, 25.0);
  EXPECT_LT(promise_together(5.0, 4.0, 0.95, false, false, kAlike).b, 0.0);
  EXPECT_EQ(promise_together(5.0, 4.0, 0.95, false, true, kAlike).energy, 0.0);
  EXPECT_GT(promise_together(5.0, 4.0, 0.95, true, false, kAlike).energy, 25.0);
  EXPECT_EQ(promise_together(5.0, 4.0, 0.999, false, false, kAlike).energy, 0.0);
}

/// Candidates of the library at one joint, each screened once, with scores and correlation.
struct Screened {
  Library library;
  Screening screening;
  Screened(const std::vector<const char*>& effects, const std::vector<double>& z, double rho) {
    const auto n = static_cast<Eigen::Index>(effects.size());
    for (std::size_t i = 0; i < effects.size(); ++i) {
      Candidate c;
      c.effect = effects[i];
      c.joints = {0};
      for (const std::string_view id : find_effect(effects[i])->contains)
        c.contains.emplace_back(id);
      c.parameters.resize(1);
      c.probes = {{1.0}};
      library.candidates.push_back(std::move(c));
      ProbeScore p;
      p.candidate = i, p.z = z[i], p.score = std::abs(z[i]), p.signature = 2.0;
      screening.probes.push_back(p);
    }
    screening.correlation = Eigen::MatrixXd::Constant(n, n, rho);
    screening.correlation.diagonal().setOnes();
    screening.critical = 3.5;
  }
  std::vector<CandidatePair> pairs(double least = 0.0) const {
    return promising_pairs(Settings{}, library, screening, least);
  }
};

TEST(PromisingPairs, TwoThatOnlyTogetherExplainAreProposed) {
  // alike, and pulling against each other: alone each promises a ninth of what both do
  const Screened s({"servo_p_gain", "coulomb_friction"}, {9.0, -9.0}, 0.8);
  ASSERT_EQ(s.pairs().size(), 1U);
  const CandidatePair& pair = s.pairs().front();
  EXPECT_NEAR(pair.promise, 2.0 * 81.0 * 1.8 / (1.0 - 0.64), 1e-9);
  EXPECT_NEAR(pair.first.amount, -pair.second.amount, 1e-12);
  EXPECT_LT(pair.p, 1e-6);
  EXPECT_TRUE(s.pairs(1e9).empty()) << "what promises too little to matter is not tried";
}

TEST(PromisingPairs, WhatOneExplainsAloneIsNoPair) {
  // the second has the score that its likeness to the first gives it
  EXPECT_TRUE(Screened({"servo_p_gain", "coulomb_friction"}, {30.0, 24.0}, 0.8).pairs().empty());
  // and chance adds no more than it does in a family of this size
  EXPECT_TRUE(Screened({"servo_p_gain", "coulomb_friction"}, {30.0, 25.5}, 0.8).pairs().empty());
}

TEST(PromisingPairs, NeitherTermsOfOneSeriesNorASpecialCaseNorOtherJoints) {
  EXPECT_TRUE(Screened({"cogging", "cable_spring"}, {9.0, -9.0}, 0.8).pairs().empty());
  EXPECT_TRUE(Screened({"payload", "link_mass"}, {9.0, -9.0}, 0.8).pairs().empty());
  EXPECT_TRUE(Screened({"servo_p_gain", "servo_p_gain"}, {9.0, -9.0}, 0.8).pairs().empty());
  Screened apart({"servo_p_gain", "coulomb_friction"}, {9.0, -9.0}, 0.8);
  apart.library.candidates[1].joints = {1};
  EXPECT_TRUE(apart.pairs().empty());
  apart.library.candidates[1].joints = {};
  EXPECT_EQ(apart.pairs().size(), 1U) << "the whole robot's may stand beside a joint's";
}

}  // namespace
}  // namespace sanso::diagnose
