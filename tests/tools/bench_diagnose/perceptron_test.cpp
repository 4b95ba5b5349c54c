// The network under the residual network: it learns what can be learned, and nothing where there is
// nothing.
#include "tools/bench/diagnose/perceptron.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tools/diagnose/stats/random.h"

namespace sanso::bench {
namespace {

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
  const Sample train = sample(3000, 0.0, 1), validation = sample(500, 0.0, 2),
               test = sample(500, 0.0, 3);
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
