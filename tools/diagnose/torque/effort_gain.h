// What one set of terms is worth over another: on blocks that neither was fitted to, in a measure
// that few blocks cannot decide; and what no set may say.
#pragma once

#include <vector>

#include "tools/diagnose/torque/effort_fit.h"

namespace sanso::diagnose {

/// Gain of `with` over `without`, block by block, where each is fitted to the other folds of the
/// fitted part; blocks that are not fitted are left out. `joints`: of their rows alone.
///
/// Two measures, as of shots on the motion side: the squared error, and its logarithm by block,
/// k log((k + a) / (k + b)), since a start at full speed holds more squares than all else together.
/// Either proves a gain at half of the level.
struct EffortGain {
  double gain = 0.0, low = 0.0;  // the surer measure, and the bound that chance leaves of it
  double share = 0.0;            // of what `without` leaves at these joints, by that measure
};
/// a, b: losses by block without and with it; blocks with counts 0 are left out.
EffortGain gain_of(const std::vector<double>& a, const std::vector<double>& b,
                   const BlockCounts& counts, const Settings& settings, unsigned long seed);
/// Both predict every fold of the fitted blocks from the other folds. `joints` empty: of all rows.
EffortGain crossed_gain(const EffortDesign& design, const std::vector<std::size_t>& without,
                        const std::vector<std::size_t>& with, const BlockCounts& fitted,
                        const std::vector<std::size_t>& joints, const Settings& settings,
                        unsigned long seed);

/// Ripples of the friction are no larger than the dry friction that they ripple, at any joint:
/// friction takes energy at every angle.
bool friction_is_positive(const EffortDesign& design, const std::vector<std::size_t>& active,
                          const EffortValues& x);

}  // namespace sanso::diagnose
