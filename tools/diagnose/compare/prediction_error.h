// Stacked whitened prediction errors of a model, and their derivatives. One pass = every shot
// simulated once.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/diagnose/compare/candidate.h"
#include "tools/diagnose/compare/problem.h"

namespace sanso::diagnose {

/// r = (measured - predicted) / sigma of all shots; see Problem for the layout. One pass.
Eigen::VectorXd prediction_error(const Problem& problem, const Library& library,
                                 const Model& model);

/// The same with chance drawn (lost commands, instants of readings) instead of averaged; `seed` not
/// 0. One pass.
Eigen::VectorXd drawn_prediction_error(const Problem& problem, const Library& library,
                                       const Model& model, std::uint64_t seed);

/// A command that did not reach the servo of `joint`: the one of the row before stays.
struct LostCommand {
  int source = 0, joint = 0;
  std::size_t row = 0;
  bool operator<(const LostCommand& other) const;  // by source, joint, row
};

/// Puts the commands that were received in the place of those that were sent.
void hold(Problem& problem, std::vector<LostCommand> lost);

/// The same when these commands are lost (any order). Simulated are the shots with `wanted_shots`
/// not 0 and the branches of the tree that hold one of `joints`; everything else stays as in
/// `base`.
Eigen::VectorXd prediction_error_with_lost(const Problem& problem, const Library& library,
                                           const Model& model, const Eigen::VectorXd& base,
                                           std::vector<LostCommand> lost,
                                           const std::vector<char>& wanted_shots,
                                           const std::vector<int>& joints);

/// Measures what the search's step adds to the predictions of `model` and stores it in the problem:
/// every later prediction error is that of the limit of small steps, to first order of the
/// integrator, as long as the model stays near.
void correct_step(Problem& problem, const Library& library, const Model& model);

/// The same for a model that differs from the one of `base` (its prediction error) at `joints` only
/// (empty: anywhere).
/// Only the branches of the tree that hold one of them are simulated: legs on one stand do not feel
/// each other.
Eigen::VectorXd prediction_error_near(const Problem& problem, const Library& library,
                                      const Model& model, const Eigen::VectorXd& base,
                                      const std::vector<int>& joints);

/// Error when every start is moved: joint `joint` by `dq0` [rad] and `ddq0` [rad/s]; joint -1: all
/// joints together.
Eigen::VectorXd prediction_error_from_moved_start(const Problem& problem, const Library& library,
                                                  const Model& model, int joint, double dq0,
                                                  double ddq0);

/// The starts of the shots are known only within the smoother's deviation. Their influence is
/// eliminated: the energy of an error is r' M r with M = I - J W J', J the derivative by the shot's
/// start, W = (J'J + P^-1)^-1.
class StartElimination {
 public:
  StartElimination(const Problem& problem, const Library& library, const Model& model);

  /// columns' M columns, summed over the shots of every part with a weight by shot (empty: all 1).
  /// Result[part] is K x K.
  std::vector<Eigen::MatrixXd> gram_by(const Eigen::MatrixXd& columns, int parts,
                                       const std::function<int(const Shot&)>& part_of,
                                       const Eigen::VectorXd& weights = {}) const;
  Eigen::MatrixXd gram(const Eigen::MatrixXd& columns, const Eigen::VectorXd& weights = {}) const;
  /// The same for columns kept in single precision (thousands of signatures); products are summed
  /// in double precision.
  Eigen::MatrixXd gram(const Eigen::MatrixXf& columns, const Eigen::VectorXd& weights) const;
  /// The same by held-out group; their sum is gram().
  std::vector<Eigen::MatrixXd> gram_by_group(const Eigen::MatrixXf& columns,
                                             const Eigen::VectorXd& weights) const;
  /// r' M r by shot.
  Eigen::VectorXd energy_by_shot(const Eigen::VectorXd& r) const;
  /// M r: what of an error cannot come from the starts.
  Eigen::VectorXd project(const Eigen::VectorXd& r) const;

 private:
  /// Channels of one branch of the tree: a contiguous piece of every shot that only this branch's
  /// starts move.
  struct Block {
    std::size_t first_channel, channels;
    Eigen::Index first_start, starts;
  };
  void make_blocks();
  template <class Columns>
  std::vector<Eigen::MatrixXd> gram_of(const Columns& columns, int parts,
                                       const std::function<int(const Shot&)>& part_of,
                                       const Eigen::VectorXd& weights) const;
  template <class Columns>
  std::vector<Eigen::Index> support(const Columns& columns, const Block& block) const;

  Eigen::Index entries(const Shot& shot) const {
    return static_cast<Eigen::Index>(shot.rows * problem_->channels.size());
  }
  const Problem* problem_;
  // stacked entries x 2n: d r / d start, in units of the starts' deviations
  Eigen::MatrixXd J_;
  std::vector<Eigen::MatrixXd> W_;  // by shot
  std::vector<Block> blocks_;
};

}  // namespace sanso::diagnose
