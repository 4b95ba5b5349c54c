// The regression: columns of terms over rows, normal equations by block, so that leaving out and
// resampling blocks costs nothing.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/diagnose/torque/effort_terms.h"

namespace sanso::diagnose {

/// Which blocks take part, and how often: 0 or 1, or a resample's counts.
using BlockCounts = std::vector<double>;

/// Values of all columns; those of terms that do not take part are zero.
using EffortValues = Eigen::VectorXd;

class EffortDesign {
 public:
  explicit EffortDesign(const EffortRows& rows);

  const EffortRows& rows() const { return *rows_; }
  const std::vector<EffortTerm>& terms() const { return terms_; }
  /// Of a term's columns, which lie side by side.
  Eigen::Index first_column(std::size_t term) const { return first_column_[term]; }
  /// Value c of a term.
  double value(const EffortValues& x, std::size_t term, std::size_t c) const {
    return x[first_column(term) + static_cast<Eigen::Index>(c)];
  }
  Eigen::Index columns() const { return X_.cols(); }
  /// Mean of the columns over every row, N m a unit. Returns the index of the first.
  std::size_t append(std::vector<EffortTerm> terms);

  /// What one unit of the recorded effort is in N m at a joint (1: nothing to scale); its rows'
  /// targets are scaled by it. `from_zero`: of a drive whose gain these data do not determine the
  /// nominal effort is not subtracted.
  void scale(std::size_t joint, double gain, bool from_zero);
  /// Keeps a one-column term at zero, and says in which unit the joint's others are.
  void hold(std::size_t term, const std::string& unit);
  /// Recorded effort of a row in the unit of its target; that unit.
  double recorded(std::size_t row) const;
  std::string unit(std::size_t joint) const;

  /// effort less what the nominal model needs, N m, by row.
  const Eigen::VectorXd& target() const { return target_; }
  const Eigen::MatrixXd& X() const { return X_; }
  /// Weights of the rows, 1 / variance; forms the normal equations of every block anew.
  void set_weights(const Eigen::VectorXd& weights);
  const Eigen::VectorXd& weights() const { return weights_; }

  /// Best values of the columns of `active` terms within their bounds, on `counts`.
  EffortValues fit(const std::vector<std::size_t>& active, const BlockCounts& counts) const;
  /// Weighted squared error of every block (not counted), of all joints or of these.
  std::vector<double> losses(const EffortValues& x,
                             const std::vector<std::size_t>& joints = {}) const;
  /// target - X x by row, N m.
  Eigen::VectorXd residual(const EffortValues& x) const { return target_ - X_ * x; }

 private:
  struct Normal {
    Eigen::MatrixXd G;
    Eigen::VectorXd c;
    double yy = 0.0;
  };
  void form_blocks();

  const EffortRows* rows_;
  std::vector<EffortTerm> terms_;
  std::vector<Eigen::Index> first_column_;
  std::vector<double> gain_;     // by joint
  std::vector<char> from_zero_;  // by joint
  Eigen::MatrixXd X_;
  Eigen::VectorXd target_, weights_;
  std::vector<Normal> block_;
};

/// Weights by row: 1 / variance of the joint's errors (robust), less for rows that stand out
/// (Huber).
Eigen::VectorXd robust_weights(const EffortRows& rows, const Eigen::VectorXd& residual,
                               double outlier);

}  // namespace sanso::diagnose
