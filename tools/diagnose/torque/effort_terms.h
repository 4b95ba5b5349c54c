// What may be missing in an effort, as columns of a regression: friction, rotor, spring, ripple,
// links, a drive that another joint turns too, and what a nominal model may be wrong by.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/diagnose/effects/effect.h"
#include "tools/diagnose/effects/effort_only.h"
#include "tools/diagnose/torque/effort_rows.h"

namespace sanso::diagnose {

/// Adds the columns' values at one instant to `out`, joint by joint: out[joint * columns + column].
using ColumnsAt = std::function<void(const MotionSample&, const std::vector<NeededEffort>&,
                                     std::vector<double>& out)>;

/// One name at one place, with one column a parameter: effort += sum of value * column.
struct EffortTerm {
  std::string effect;  // id of the library, or of effects/effort_only.h
  std::string family;
  EffortColumns law;                // as the library has it; of the others, the same of them
  std::vector<std::string> where;   // joints or a link
  std::vector<std::size_t> joints;  // whose effort it may change
  std::vector<std::string> parameters, units;
  std::vector<double> low, high;  // bounds of the values, natural units
  // `low` is where nothing of it is left (no friction, no mass); else a limit like `high`
  bool low_is_nothing = true;
  std::map<std::string, double> fixed;  // parameters that are no sizes: order, speed, ratio
  bool nuisance = false;                // within what a nominal model may be wrong by
  double precision = 0.0;               // of a nuisance: 1 / variance
  std::function<ColumnsAt(const EffortRecording&)> columns;

  std::size_t size() const { return parameters.size(); }
  /// A limit of what is plausible, not of what is possible, stopped the value of column c.
  bool stopped(std::size_t c, double value) const {
    return value >= high[c] || (!low_is_nothing && value <= low[c]);
  }
  bool same_as(const EffortTerm& other) const {
    return effect == other.effect && where == other.where && fixed == other.fixed &&
           nuisance == other.nuisance;
  }
};

/// Every term but the ripples, whose order is looked for. Bounds keep totals physical: friction
/// and inertia, the nominal model's included, are not negative.
std::vector<EffortTerm> effort_terms(const EffortRows& rows, const Settings& settings);

/// A ripple of the library, of one order, at a joint.
EffortTerm ripple_term(const EffortRows& rows, const Effect& effect, std::size_t joint, int order);

}  // namespace sanso::diagnose
