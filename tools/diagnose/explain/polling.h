// What commands that wait for a servo to look make readings scatter: within tolerance, and no
// missing physics.
#pragma once

#include "tools/diagnose/explain/select.h"

namespace sanso::diagnose {

/// Variance by entry of the projected error, in the units of the scales. Takes
/// `decisions.tolerance_draws` passes.
Eigen::VectorXd scatter_of_polling(const Selection& selection, unsigned long seed);

}  // namespace sanso::diagnose
