// Lost commands are events: each one happened at a row, and the simulation in which just that
// command is held shows the motion that was recorded. They are looked for one by one where a fitted
// model leaves more than noise.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <vector>

#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {

/// What is said about the lost commands of one candidate (an effect that sets JointParams::loss).
struct LossScore {
  std::size_t candidate = 0;
  std::vector<LostCommand> lost;  // those found, in order
  // losses found among the commands whose loss would show
  int seen = 0, visible = 0;
  // seen / visible, with its 95 % interval (Wilson, a run of losses is one)
  double size = 0.0, low = 0.0, high = 0.0;
  // no larger share is lost among the commands whose loss shows little, or in one recording
  bool blind = false;
  // most of what was found no run of losses there would show: what merely looks like holds
  bool unseen = false;
  // standard errors between a typical loss and a whole one, the model's own included: losses.cpp
  double misfit = INFINITY;
  // share of what losses mend that commands which go too far would (hunt.h)
  double mirrored = 0.0;
  // of the clearest loss, times the number of commands tried
  double p_family = 1.0;
  // noise levels squared that the losses take from the position error, starts taken out
  double energy = 0.0;
  // noise levels in the position error with the losses, see position_error_level
  double left = INFINITY;
  // of the position error's energy beyond noise, the share that is left with the losses
  double left_share = 1.0;
  // error with the losses, starts taken out, in noise levels (Observed::floor)
  Eigen::VectorXd repaired;
};

/// Whether a candidate makes commands be lost, and nothing else.
bool loses_commands(const Candidate& c, const SimParams& params);

/// Looks for lost commands at every joint where a candidate of the library could have lost some.
/// Shots whose error is noise are not tried. A hold is believed when its likelihood ratio beats the
/// number of holds tried at the family-wise level: for two fixed hypotheses P(ratio > x) <= 1 / x,
/// whatever the size of what the hold changes. Empty: none found.
std::optional<LossScore> find_losses(const Surroundings& around, const FitResult& final);

}  // namespace sanso::diagnose
