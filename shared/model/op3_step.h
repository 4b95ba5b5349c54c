// The whole-body step for one state in plain doubles: what the controller, tests and slow tools
// call.
// Many states at once: step_batch.h.
#pragma once

#include "shared/model/kernel/step.h"

namespace sanso::model {

using StepScratch = portable::StepScratch<double>;

/// f_A(x, u): see kernel/step.h. x (37), u (12), h [s]; x_next may alias x.
void analytical_step(const StepModel& model, const Ground& ground, const double* x, const double* u,
                     double h, int substeps, double* x_next, StepScratch& scratch);

}  // namespace sanso::model
