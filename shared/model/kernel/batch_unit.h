// Body of one instruction set's copy of the batch step. Include once in a .cpp that defines SANSO_ISA and SANSO_LANES.
#include "shared/model/kernel/step.h"
#include "shared/model/step_batch.h"

namespace sanso::model::SANSO_ISA {

using P = Pack<SANSO_LANES>;

inline P load(const double* p) { return P(*reinterpret_cast<const P::Lanes*>(p)); }
inline void store(P a, double* p) { *reinterpret_cast<P::Lanes*>(p) = a.v; }

void step_group(const StepModel& model, const Ground& ground, const StateLanes& x, const InputLanes& u,
                const BatchStep& step, StateLanes& x_next, ContactLanes* contact) {
  for (int first = 0; first < kLanes; first += SANSO_LANES) {
    P xs[kNx], us[kNu];
    StepScratch<P> scratch;
    for (int i = 0; i < kNx; ++i) xs[i] = load(&x.v[i][first]);
    for (int i = 0; i < kNu; ++i) us[i] = load(&u.v[i][first]);
    P* lambda = &scratch.lambda[0][0][0];
    scratch.warm_start = step.warm_start && contact;
    if (scratch.warm_start)
      for (int i = 0; i < kNumContactRows; ++i) lambda[i] = load(&contact->v[i][first]);
    analytical_step(model, ground, xs, us, step.h, step.substeps, xs, scratch);
    for (int i = 0; i < kNx; ++i) store(xs[i], &x_next.v[i][first]);
    if (contact)
      for (int i = 0; i < kNumContactRows; ++i) store(lambda[i], &contact->v[i][first]);
  }
}

}  // namespace sanso::model::SANSO_ISA
