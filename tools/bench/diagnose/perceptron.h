// A small regression network: two hidden layers of tanh, Adam, stopped early by rows that it is not
// trained on. In this folder for one reason: the residual network that the diagnosis is compared
// with has to be a real one. The planner's network (host/model/residual_network.h) cannot stand in:
// its 46 features and 36 outputs are those of the OP3, fixed when it is compiled, and what is
// learned here is one torque of any joint, switched by a gate.
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace sanso::bench {

struct PerceptronOptions {
  int hidden = 24;  // units of each of the two hidden layers
  int batch = 256;
  int epochs = 40;     // at most
  int patience = 6;    // epochs without a better validation error that end the training
  double rate = 3e-3;  // Adam's step
  std::uint64_t seed = 1;
};

/// y = gate(x) * net(x), scalar. Columns are samples.
class Perceptron {
 public:
  /// Trains on `x` (features x samples), `y`, with `gate` >= 0 multiplying the output; keeps the
  /// weights that are best on the validation samples. Weights of the initial network give y = 0, so
  /// "no better than nothing" is a possible answer.
  void train(const Eigen::MatrixXd& x, const Eigen::RowVectorXd& y, const Eigen::RowVectorXd& gate,
             const Eigen::MatrixXd& x_validation, const Eigen::RowVectorXd& y_validation,
             const Eigen::RowVectorXd& gate_validation, const PerceptronOptions& options);
  Eigen::RowVectorXd predict(const Eigen::MatrixXd& x, const Eigen::RowVectorXd& gate) const;
  /// Epochs until the best weights; 0: the initial network was best.
  int best_epoch() const { return best_epoch_; }

 private:
  struct Weights {
    Eigen::MatrixXd W1, W2;
    Eigen::VectorXd b1, b2;
    Eigen::RowVectorXd w3;
    double b3 = 0.0;
  };
  Eigen::RowVectorXd forward(const Weights& w, const Eigen::MatrixXd& scaled) const;
  Eigen::MatrixXd scaled(const Eigen::MatrixXd& x) const;

  Weights best_;
  Eigen::VectorXd centre_, spread_;  // of the training features
  double unit_ = 1.0;                // of the training targets
  int best_epoch_ = 0;
};

}  // namespace sanso::bench
