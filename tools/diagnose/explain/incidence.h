// Refutation: an explanation says what it changes in every channel and regime. If a change it
// promises did not happen, or happened several times over, the explanation is wrong, however well
// it fits elsewhere.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/explain/regimes.h"
#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {

/// A part of the prediction error: one kind of channel, all joints together; of positions also one
/// regime of the joint.
struct ErrorPart {
  Signal signal = Signal::q;
  std::string regime;  // empty: all of it
};
/// "position", "position, reversal", "duty": as verdict.json has it.
std::string to_string(const ErrorPart& residual);

/// What an explanation says that the data should show, and whether they do: slope of (measured
/// change) on (predicted change).
struct IncidenceRow {
  ErrorPart residual;
  double predicted = 0.0;  // size of the predicted change, in noise levels
  double slope = 0.0;      // 1: as predicted; 0: did not happen
  double low = 0.0, high = 0.0;
};

/// Rows: channel kind (all joints together) and, for positions, regime of the joint. Slope of
/// measured on promised change, interval over shots. Rows in which the promise is smaller than five
/// noise levels are left out. Torque, current and duty are judged at the recorded positions and
/// velocities (effort_law.h), where a promise has at least the channel's floor: a drift of the
/// simulated motion contradicts nobody. `without`, `with`: fits of the model without and with the
/// explanation.
std::vector<IncidenceRow> incidence(const Surroundings& around, const Regimes& regimes,
                                    const FitResult& without, const FitResult& with);

/// The first row that refutes; empty: none. A row refutes when its whole interval is below
/// happened_least or above happened_most: the interval that holds for all rows together with 95 %.
std::string refuted_by(const std::vector<IncidenceRow>& rows, const DecisionSettings& decisions);

}  // namespace sanso::diagnose
