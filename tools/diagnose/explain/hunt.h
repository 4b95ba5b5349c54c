// The hunt for lost commands: shot by shot the change that pays most, as long as one pays.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <vector>

#include "tools/diagnose/explain/commands.h"
#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {

/// What a loss has to gain, in twice log-likelihood. N commands are tried, and for two fixed
/// hypotheses P(likelihood ratio > x) <= 1 / x, whatever the size of what the loss changes:
///
///   first    2 ln(N / p)     a run of losses: its place among all commands
///   further  2 ln(2 / p)     a further row of the run, at this end or at the other
///
/// with p the family-wise level.
struct Price {
  double first = 0.0, further = 0.0;
  /// Of all losses together, sorted; rows that follow each other are a run.
  double of(const std::vector<LostCommand>& lost) const;
};

/// A shot under way, and the changes to try next; none: all that there are.
struct Hunted {
  std::size_t shot = 0;
  std::vector<Change> promising = {};
};

/// What is taken for lost. `r` is the prediction error of the hunt's model with `lost` held; every
/// function that changes the one brings the other up to date.
struct Repaired {
  std::vector<LostCommand> lost;  // sorted
  Eigen::VectorXd r;              // noise levels
};

/// Commands of cycles that were not read, taken for lost together, at all joints.
struct Unread {
  int lost = 0, cycles = 0;
  double runs = 1.0;   // losses in a run
  double theta = 0.0;  // share of their loss that the data want: whole ones want 1
  double made = 0.0;   // energy of what they change
};

/// Squares of one joint's errors in a shot, noise levels: all of them, and those of noise alone.
struct ShotEnergy {
  double all = 0.0, noise = 0.0;
};

class Hunt {
 public:
  /// `joints`: where commands may have been lost. `model`: all else that is known.
  Hunt(const Surroundings& around, const Model& model, const std::vector<std::size_t>& joints);

  /// Whether losses take most of what stands beyond noise out of the joint's farthest shots; if
  /// not, none of them is kept. Rare bursts are a few shots, however many others there are that a
  /// tolerated model misses by a little.
  bool lost_some(std::size_t joint);
  /// Whether the commands of those cycles in which nothing was read were lost too, at all of these
  /// joints; if not, none of them is kept. A cycle has both: where they are many and far from each
  /// other, no search from one to the next finds them.
  bool lost_with_readings(const std::vector<std::size_t>& joints);
  /// Takes losses out of every shot of the joint whose error is more than noise.
  void take_all(std::size_t joint);
  /// What losses do on average was taken for a lag within tolerance: nuisances at their null.
  void forget_nuisances();
  /// Nuisances were fitted to motions with the losses in them: once more, with the losses known.
  void refit();
  /// Of each loss of the joint, alone taken back again; by shot.
  std::vector<std::vector<Change>> taken_back(std::size_t joint) const;
  /// Of each command of the joint, alone lost, or where it is lost taken back; by shot.
  std::vector<std::vector<Change>> each_alone(std::size_t joint) const;

  const Problem& problem() const { return problem_; }  // in noise levels
  const Library& library() const { return library_; }
  const Commands& commands() const { return commands_; }
  const StartElimination& starts() const { return starts_; }
  const std::optional<Unread>& with_readings() const { return with_readings_; }
  const Price& price() const { return price_; }
  const Repaired& repaired() const { return state_; }
  const Eigen::VectorXd& error_before() const { return first_; }  // with nothing lost
  double best_gain() const { return best_gain_; }                 // of one change
  /// What the clearest loss mends in each of the joint's farthest shots, together, and what a
  /// command would mend that goes as far beyond what was sent as a loss falls behind it: the second
  /// over the first. What is no loss is mended by either.
  double mirrored() const { return mirrored_.beyond / std::max(mirrored_.losses, 1e-300); }

 private:
  ShotEnergy energy_in(const Eigen::VectorXd& projected, const Shot& shot, std::size_t joint) const;
  std::vector<std::size_t> outstanding(std::size_t joint) const;
  double beyond_noise(std::size_t joint, const std::vector<std::size_t>& shots) const;
  std::vector<LostCommand> lost_in(const std::vector<LostCommand>& lost, const Shot& shot,
                                   std::size_t joint) const;
  std::vector<Change> all_changes(const Shot& shot, std::size_t joint) const;
  std::vector<Change> promising_after(const std::vector<Change>& sorted, const Shot& shot,
                                      std::size_t joint) const;
  std::vector<std::vector<Change>> tried_alone(std::size_t joint,
                                               std::vector<std::vector<Change>> changes) const;
  void try_out(std::size_t joint, const std::vector<Hunted>& hunted,
               std::vector<std::vector<Change>>& of) const;
  void note_mirrored(const std::vector<Change>& tried);
  std::vector<Hunted> round(std::size_t joint, const std::vector<Hunted>& hunted,
                            std::vector<char>& moved);
  std::vector<LostCommand> unread(const std::vector<std::size_t>& joints, int shift) const;
  std::size_t take(std::size_t joint, const std::vector<std::size_t>& shots);

  const Library& library_;
  Model model_;  // refit() moves its nuisances
  const Problem problem_;
  StartElimination starts_;  // at model_
  const Commands commands_;
  Price price_;
  Repaired state_;
  const Eigen::VectorXd first_;
  double best_gain_ = 0.0;
  std::optional<Unread> with_readings_;
  struct {
    double losses = 0.0, beyond = 0.0;  // gains
  } mirrored_;
};

}  // namespace sanso::diagnose
