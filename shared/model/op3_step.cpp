// Instantiates the kernel of the whole-body step for one state in plain doubles; no intrinsics,
// so it runs on any board.
#include "shared/model/op3_step.h"

namespace sanso::model {

void analytical_step(const StepModel& model, const Ground& ground, const double* x, const double* u,
                     double h, int substeps, double* x_next, StepScratch& scratch) {
  portable::analytical_step(model, ground, x, u, h, substeps, x_next, scratch);
}

}  // namespace sanso::model
