// What the unknown starts of the shots take out of an error.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "tools/diagnose/compare/candidate.h"
#include "tools/diagnose/compare/problem.h"

namespace sanso::diagnose {

/// The starts of the shots are known only within the smoother's deviation. Their influence is
/// eliminated: the energy of an error is r' M r with M = I - J W J', J the derivative by the shot's
/// start, W = (J'J + P^-1)^-1.
class StartElimination {
 public:
  StartElimination(const Problem& problem, const Library& library, const Model& model);

  /// columns' M columns, summed over the shots of every part with a weight by shot (empty: all 1).
  /// Result[part] is K x K.
  std::vector<Eigen::MatrixXd> gram_by(const Eigen::MatrixXd& columns, std::size_t parts,
                                       const std::function<std::size_t(const Shot&)>& part_of,
                                       const Eigen::VectorXd& weights = {}) const;
  Eigen::MatrixXd gram(const Eigen::MatrixXd& columns, const Eigen::VectorXd& weights = {}) const;
  /// The same for columns kept in single precision (thousands of signatures); products are summed
  /// in double precision.
  Eigen::MatrixXd gram(const Eigen::MatrixXf& columns, const Eigen::VectorXd& weights) const;
  /// The same by held-out group; their sum is gram().
  std::vector<Eigen::MatrixXd> gram_by_group(const Eigen::MatrixXf& columns,
                                             const Eigen::VectorXd& weights) const;
  /// r' M r by shot. `wanted`: the only ones (by shot, not 0), 0 for all others; empty: all.
  Eigen::VectorXd energy_by_shot(const Eigen::VectorXd& r,
                                 const std::vector<char>& wanted = {}) const;
  /// M r: what of an error cannot come from the starts.
  Eigen::VectorXd project(const Eigen::VectorXd& r) const;

 private:
  /// Channels of one branch of the tree: a contiguous piece of every shot that only this branch's
  /// starts move.
  struct Block {
    std::size_t first_channel, channels, first_start, starts;
  };
  void make_blocks();
  template <class Columns>
  std::vector<Eigen::MatrixXd> gram_of(const Columns& columns, std::size_t parts,
                                       const std::function<std::size_t(const Shot&)>& part_of,
                                       const Eigen::VectorXd& weights) const;
  template <class Columns>
  std::vector<Eigen::Index> support(const Columns& columns, const Block& block) const;

  std::shared_ptr<const Comparison> comparison_;
  // stacked entries x 2n: d r / d start, in units of the starts' deviations
  Eigen::MatrixXd J_;
  std::vector<Eigen::MatrixXd> W_;  // by shot
  std::vector<Block> blocks_;
};

}  // namespace sanso::diagnose
