// The methods that the diagnosis is compared with: real ones, on known answers.
#include "tools/bench/diagnose/baselines.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tools/bench/diagnose/perceptron.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::bench {
namespace {

/// Five groups of rows: one nuisance and four probes, error = -(amounts . probes) + noise.
diagnose::FirstLook made(const Eigen::VectorXd& amounts) {
  constexpr int kGroups = 5, kRows = 200, kProbes = 4;
  diagnose::FirstLook look;
  look.effect = {"viscous_friction", "coulomb_friction", "backlash", "cogging"};
  look.family = {"friction", "friction", "transmission", "transmission"};
  look.z.assign(kProbes, 0.0);
  look.nuisances = 1;
  diagnose::Random random(11);
  for (int g = 0; g < kGroups; ++g) {
    Eigen::MatrixXd columns(kRows, 1 + kProbes + 1);
    for (int r = 0; r < kRows; ++r) {
      for (int c = 0; c < 1 + kProbes; ++c) columns(r, c) = random.normal();
      columns(r, 2) = 0.8 * columns(r, 1) + 0.6 * columns(r, 2);  // two kinds of friction look alike
      columns(r, 1 + kProbes) = random.normal();
    }
    columns.col(1 + kProbes) -= columns.middleCols(1, kProbes) * amounts;
    look.by_group.emplace_back(columns.transpose() * columns);
  }
  return look;
}

TEST(Baselines, NothingIsNamedWhereTheErrorIsNoise) {
  const diagnose::FirstLook look = made(Eigen::Vector4d::Zero());
  EXPECT_TRUE(largest_score(look).empty());
  EXPECT_TRUE(fit_everything(look).empty());
  EXPECT_TRUE(sparse_regression(look).empty());
  EXPECT_TRUE(friction_ladder(look).empty());
}

TEST(Baselines, TwoEffectsAreFoundByTheMethodsThatCan) {
  const diagnose::FirstLook look = made(Eigen::Vector4d(0.0, 1.0, 0.0, 0.8));
  const Names both{"coulomb_friction", "cogging"}, by_t{"cogging", "coulomb_friction"};
  EXPECT_EQ(largest_score(look), Names{"coulomb_friction"});
  EXPECT_EQ(fit_everything(look), by_t);
  EXPECT_EQ(sparse_regression(look), both);
  EXPECT_EQ(friction_ladder(look), Names{"coulomb_friction"});
}

TEST(Baselines, WithoutGroupsNothingIsNamed) { EXPECT_TRUE(sparse_regression(diagnose::FirstLook{}).empty()); }

/// sin of a weighted sum, gated; training, validation and test rows are drawn apart.
struct Sample {
  Eigen::MatrixXd x;
  Eigen::RowVectorXd y, gate;
};
Sample sample(int rows, double noise, std::uint64_t seed) {
  diagnose::Random random(seed);
  Sample s{Eigen::MatrixXd(3, rows), Eigen::RowVectorXd(rows), Eigen::RowVectorXd(rows)};
  for (int k = 0; k < rows; ++k) {
    for (int f = 0; f < 3; ++f) s.x(f, k) = 2.0 * random.uniform() - 1.0;
    s.gate[k] = random.uniform();
    s.y[k] = 0.01 * s.gate[k] * std::sin(2.0 * s.x(0, k) + s.x(1, k)) + noise * random.normal();
  }
  return s;
}

TEST(Perceptron, LearnsASmoothFunctionAndRepeatsItself) {
  const Sample train = sample(3000, 0.0, 1), validation = sample(500, 0.0, 2), test = sample(500, 0.0, 3);
  Perceptron network, again;
  network.train(train.x, train.y, train.gate, validation.x, validation.y, validation.gate, {});
  again.train(train.x, train.y, train.gate, validation.x, validation.y, validation.gate, {});
  const Eigen::RowVectorXd out = network.predict(test.x, test.gate);
  EXPECT_LT((out - test.y).squaredNorm(), 0.05 * test.y.squaredNorm());
  EXPECT_EQ((out - again.predict(test.x, test.gate)).squaredNorm(), 0.0);
}

TEST(Perceptron, StopsEarlyWhereThereIsNothingToLearn) {
  Sample train = sample(400, 0.0, 4), validation = sample(400, 0.0, 5);
  diagnose::Random random(6);
  for (double& y : train.y) y = random.normal();
  for (double& y : validation.y) y = random.normal();
  Perceptron network;
  network.train(train.x, train.y, train.gate, validation.x, validation.y, validation.gate, {});
  EXPECT_LT(network.best_epoch(), PerceptronOptions{}.epochs / 2);
  EXPECT_LT(network.predict(train.x, train.gate).squaredNorm(), 0.2 * train.y.squaredNorm());
}

}  // namespace
}  // namespace sanso::bench
