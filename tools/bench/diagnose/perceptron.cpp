// Forward pass, gradient and Adam, batch by batch.
#include "tools/bench/diagnose/perceptron.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "tools/diagnose/stats/random.h"

namespace sanso::bench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;

/// Adam (Kingma and Ba 2015) on one block of weights.
class Adam {
 public:
  void step(Eigen::Ref<MatrixXd> weights, const MatrixXd& gradient, double rate) {
    if (m_.size() == 0) m_ = v_ = MatrixXd::Zero(gradient.rows(), gradient.cols());
    constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kTiny = 1e-8;
    ++count_;
    m_ = kBeta1 * m_ + (1.0 - kBeta1) * gradient;
    v_ = kBeta2 * v_ + (1.0 - kBeta2) * gradient.cwiseAbs2();
    const double c1 = 1.0 - std::pow(kBeta1, count_), c2 = 1.0 - std::pow(kBeta2, count_);
    weights.array() -= rate * (m_.array() / c1) / ((v_.array() / c2).sqrt() + kTiny);
  }

 private:
  MatrixXd m_, v_;
  int count_ = 0;
};

MatrixXd normal_matrix(Index rows, Index cols, double deviation, diagnose::Random& random) {
  MatrixXd out(rows, cols);
  for (Index c = 0; c < cols; ++c) {
    for (Index r = 0; r < rows; ++r) out(r, c) = deviation * random.normal();
  }
  return out;
}

void shuffle(std::vector<Index>& order, diagnose::Random& random) {
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random.below(i)]);
}

}  // namespace

MatrixXd Perceptron::scaled(const MatrixXd& x) const {
  return (x.colwise() - centre_).array().colwise() / spread_.array();
}

RowVectorXd Perceptron::forward(const Weights& w, const MatrixXd& x) const {
  const MatrixXd h1 = ((w.W1 * x).colwise() + w.b1).array().tanh();
  const MatrixXd h2 = ((w.W2 * h1).colwise() + w.b2).array().tanh();
  return (w.w3 * h2).array() + w.b3;
}

RowVectorXd Perceptron::predict(const MatrixXd& x, const RowVectorXd& gate) const {
  return unit_ * forward(best_, scaled(x)).cwiseProduct(gate);
}

void Perceptron::train(const MatrixXd& x, const RowVectorXd& y, const RowVectorXd& gate,
                       const MatrixXd& x_validation, const RowVectorXd& y_validation,
                       const RowVectorXd& gate_validation, const PerceptronOptions& options) {
  centre_ = x.rowwise().mean();
  spread_ = (x.colwise() - centre_).rowwise().norm() /
            std::sqrt(static_cast<double>(std::max<Index>(1, x.cols())));
  spread_ = spread_.cwiseMax(1e-9);
  unit_ = std::max(1e-12, y.norm() / std::sqrt(static_cast<double>(std::max<Index>(1, y.size()))));
  const MatrixXd xs = scaled(x), xv = scaled(x_validation);
  const RowVectorXd ys = y / unit_, yv = y_validation / unit_;

  diagnose::Random random(options.seed);
  const Index h = options.hidden, n = x.rows();
  Weights w{normal_matrix(h, n, 1.0 / std::sqrt(static_cast<double>(n)), random),
            normal_matrix(h, h, 1.0 / std::sqrt(static_cast<double>(h)), random),
            Eigen::VectorXd::Zero(h), Eigen::VectorXd::Zero(h), RowVectorXd::Zero(h)};
  Adam a1, a2, a3, c1, c2, c3;
  best_ = w;
  best_epoch_ = 0;
  double least = yv.squaredNorm();
  std::vector<Index> order(static_cast<std::size_t>(x.cols()));
  std::iota(order.begin(), order.end(), Index{0});
  for (int epoch = 1; epoch <= options.epochs && epoch - best_epoch_ <= options.patience; ++epoch) {
    shuffle(order, random);
    for (std::size_t from = 0; from < order.size();
         from += static_cast<std::size_t>(options.batch)) {
      const std::size_t until =
          std::min(order.size(), from + static_cast<std::size_t>(options.batch));
      const std::vector<Index> at(order.begin() + static_cast<std::ptrdiff_t>(from),
                                  order.begin() + static_cast<std::ptrdiff_t>(until));
      const MatrixXd xb = xs(Eigen::all, at);
      const RowVectorXd yb = ys(at), gb = gate(at);
      const MatrixXd h1 = ((w.W1 * xb).colwise() + w.b1).array().tanh();
      const MatrixXd h2 = ((w.W2 * h1).colwise() + w.b2).array().tanh();
      const RowVectorXd out = (w.w3 * h2).array() + w.b3;
      const double share = 1.0 / static_cast<double>(at.size());
      const RowVectorXd d3 = share * (out.cwiseProduct(gb) - yb).cwiseProduct(gb);
      const MatrixXd d2 = (w.w3.transpose() * d3).array() * (1.0 - h2.array().square());
      const MatrixXd d1 = (w.W2.transpose() * d2).array() * (1.0 - h1.array().square());
      MatrixXd b3 = MatrixXd::Constant(1, 1, w.b3);
      c3.step(b3, MatrixXd::Constant(1, 1, d3.sum()), options.rate);
      w.b3 = b3(0, 0);
      a3.step(w.w3, d3 * h2.transpose(), options.rate);
      a2.step(w.W2, d2 * h1.transpose(), options.rate);
      c2.step(w.b2, d2.rowwise().sum(), options.rate);
      a1.step(w.W1, d1 * xb.transpose(), options.rate);
      c1.step(w.b1, d1.rowwise().sum(), options.rate);
    }
    const double error = (forward(w, xv).cwiseProduct(gate_validation) - yv).squaredNorm();
    if (error < least) least = error, best_ = w, best_epoch_ = epoch;
  }
}

}  // namespace sanso::bench
