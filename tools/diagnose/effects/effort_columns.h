// What an effect is where the motion is given and the effort is asked: columns of a regression
// whose values are parameters of the effect. The room torque/ makes the columns of each kind; which
// effects have some, in which order and within which bounds, stands with the effect.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "tools/diagnose/settings.h"
#include "tools/diagnose/sim/sim_params.h"

namespace sanso::diagnose {

enum class EffortKind {
  none,    // does not show in an effort at a given motion, or not in proportion
  joint,   // its own law at its joint, linear in the values
  ripple,  // the same with an order in the angle, which is looked for
  link,    // what inverse dynamics gain by it
  share,   // the recorded effort is a multiple of the needed one
  zero     // links are weighed in another pose
};

/// What a term does to the dry friction of its joint, which is negative at no angle.
enum class DryFriction { none, adds, ripples };

/// A quantity that a nominal model states with finite accuracy: always in the regression, drawn to
/// nothing. Not the directions of Effect::tolerances: here motors give no damping of their own.
struct EffortTolerance {
  int order = 0;  // among those of a joint
  double ToleranceSettings::*deviation = nullptr;
  /// What the deviation is a share of; not positive: this joint has no such quantity.
  std::function<double(const SimParams&, std::size_t joint)> of{};
};

struct EffortColumns {
  EffortKind kind = EffortKind::none;
  int order = 0;                       // in which terms of a kind are asked for
  std::vector<std::size_t> values{0};  // parameters that are values of columns
  // the others' values, one term each (speeds in usual speeds of the joint); empty: their null
  std::vector<std::vector<double>> held{};
  double JointSettings::*stated = nullptr;  // the most that can be taken away
  DryFriction dry = DryFriction::none;
  bool beside_gain = false;  // fitted beside a gain of the drive that nobody knows
  // parameter that is a constant torque: an effort that is off by a constant lacks it
  std::optional<std::size_t> constant{};
  // of a link: the values are lengths and reach as far as the link
  bool lengths = false;
  // of a link: no more than the parameter's own bound
  bool bounded = false;
  // of a link: beyond it, it stands back where another term of its joint does nearly as well
  double wild = std::numeric_limits<double>::infinity();
  // of a share: further off, the column is not what the model takes it for
  double most = std::numeric_limits<double>::infinity();
  std::optional<EffortTolerance> tolerance{};
};

}  // namespace sanso::diagnose
