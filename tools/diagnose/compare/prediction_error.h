// Stacked whitened prediction errors of a model, and their derivatives. One pass = every shot
// simulated once.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tools/diagnose/compare/candidate.h"
#include "tools/diagnose/compare/problem.h"
#include "tools/diagnose/sim/simulator.h"

namespace sanso::diagnose {

/// r = (measured - predicted) / sigma of all shots; see Comparison for the layout. One pass.
Eigen::VectorXd prediction_error(const Problem& problem, const Library& library,
                                 const Model& model);

/// The same with chance drawn (lost commands, instants of readings) instead of averaged; `seed` not
/// 0. One pass.
Eigen::VectorXd drawn_prediction_error(const Problem& problem, const Library& library,
                                       const Model& model, std::uint64_t seed);

/// The same where every command waits for a servo that looks now and then
/// (ToleranceSettings::poll): what a model says of the delay is the mean of what was drawn.
Eigen::VectorXd polled_prediction_error(const Problem& problem, const Library& library,
                                        const Model& model, std::uint64_t seed);

/// A command that did not reach the servo of `joint`: the one of the row before stays.
struct LostCommand {
  std::size_t source = 0, joint = 0;
  std::size_t row = 0;
  bool operator<(const LostCommand& other) const;  // by source, joint, row
};

/// The same problem with the commands that were received in the place of those that were sent.
Problem with_lost(const Problem& problem, std::vector<LostCommand> lost);

/// The prediction error when these commands are lost (any order). Simulated are the shots with
/// `wanted_shots` not 0 and the branches of the tree that hold one of `joints`; everything else
/// stays as in `base`.
Eigen::VectorXd prediction_error_with_lost(const Problem& problem, const Library& library,
                                           const Model& model, const Eigen::VectorXd& base,
                                           std::vector<LostCommand> lost,
                                           const std::vector<char>& wanted_shots,
                                           const std::vector<std::size_t>& joints);

/// The same problem with what the search's step adds to the predictions of `model`: every
/// prediction error of it is that of the limit of small steps, to first order of the integrator, as
/// long as the model stays near. Two passes.
Problem step_corrected(const Problem& problem, const Library& library, const Model& model);

/// What servos and transmissions of a model remember where its shots start. A pass of a model that
/// remembers alike (sim/memory.h) takes it over and follows no recording; that changes no bit.
class Remembered {
 public:
  /// `shots`: the only ones (by shot, not 0); empty: all. A pass that takes it over has the same.
  Remembered(const Problem& problem, const Library& library, const Model& model,
             const std::vector<char>& shots = {});
  /// Inner states of one recording's shots, where a robot with these figures remembers the same;
  /// null: it may not.
  const std::vector<InnerStates>* of(std::size_t source, const SimParams& params) const;

 private:
  std::vector<SimParams> params_;                 // by source
  std::vector<std::vector<InnerStates>> starts_;  // by source
  std::vector<char> known_;                       // by source
};
/// Whether two models remember alike in every recording.
bool remember_alike(const Problem& problem, const Library& library, const Model& a, const Model& b);

/// The prediction error of a model that differs from the one of `base` (its prediction error) at
/// `joints` only (empty: anywhere).
/// Only the branches of the tree that hold one of them are simulated: legs on one stand do not feel
/// each other; and only `shots` (by shot, not 0: simulated; empty: all). `known`: what some model
/// remembers there; null: nothing is known.
Eigen::VectorXd prediction_error_near(const Problem& problem, const Library& library,
                                      const Model& model, const Eigen::VectorXd& base,
                                      const std::vector<std::size_t>& joints,
                                      const std::vector<char>& shots = {},
                                      const Remembered* known = nullptr);

/// Error when every start is moved: `joint` by `dq0` [rad] and `ddq0` [rad/s]; without one: all
/// joints together.
Eigen::VectorXd prediction_error_from_moved_start(const Problem& problem, const Library& library,
                                                  const Model& model,
                                                  std::optional<std::size_t> joint, double dq0,
                                                  double ddq0, const Remembered& known);

}  // namespace sanso::diagnose
