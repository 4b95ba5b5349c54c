// Body of one instruction set's copy of the batch step. Include once in a .cpp that defines SANSO_ISA and SANSO_LANES.
#include "shared/model/kernel/neighbour.h"
#include "shared/model/step_batch.h"

namespace sanso::model::SANSO_ISA {

using P = Pack<SANSO_LANES>;

inline P load(const double* p) { return P(*reinterpret_cast<const P::Lanes*>(p)); }
inline void store(P a, double* p) { *reinterpret_cast<P::Lanes*>(p) = a.v; }

/// `keep` (may be null): the first lane's step for its neighbours; one substep only.
void step_group(const StepModel& model, const Ground& ground, const StateLanes& x, const InputLanes& u,
                const BatchStep& step, StateLanes& x_next, ContactLanes* contact, NominalStep* keep) {
  for (int first = 0; first < kLanes; first += SANSO_LANES) {
    P xs[kNx], us[kNu], next[kNx];
    StepScratch<P> scratch;
    for (int i = 0; i < kNx; ++i) xs[i] = load(&x.v[i][first]);
    for (int i = 0; i < kNu; ++i) us[i] = load(&u.v[i][first]);
    P* lambda = &scratch.lambda[0][0][0];
    scratch.warm_start = step.warm_start && contact;
    if (scratch.warm_start)
      for (int i = 0; i < kNumContactRows; ++i) lambda[i] = load(&contact->v[i][first]);
    if (keep && first == 0) {
      StepWork<P> w;
      single_step(model, ground, xs, us, step.h, next, scratch, w);
      keep_nominal(model, w, scratch, xs, us, step.h, 0, *keep);
    } else {
      analytical_step(model, ground, xs, us, step.h, step.substeps, next, scratch);
    }
    for (int i = 0; i < kNx; ++i) store(next[i], &x_next.v[i][first]);
    if (contact)
      for (int i = 0; i < kNumContactRows; ++i) store(lambda[i], &contact->v[i][first]);
  }
}

void neighbour_group(const StepModel& model, const NominalStep& nominal, const StateLanes& x, const InputLanes& u, double h,
                     StateLanes& x_next) {
  for (int first = 0; first < kLanes; first += SANSO_LANES) {
    P xs[kNx], us[kNu], next[kNx];
    for (int i = 0; i < kNx; ++i) xs[i] = load(&x.v[i][first]);
    for (int i = 0; i < kNu; ++i) us[i] = load(&u.v[i][first]);
    neighbour_step(model, nominal, xs, us, h, next);
    for (int i = 0; i < kNx; ++i) store(next[i], &x_next.v[i][first]);
  }
}

}  // namespace sanso::model::SANSO_ISA
