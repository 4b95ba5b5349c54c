// Body of one instruction set's copy of the batch step. Include once in a .cpp that defines SANSO_ISA and SANSO_LANES.
#include "shared/model/kernel/neighbour.h"
#include "shared/model/step_batch.h"

namespace sanso::model::SANSO_ISA {

using P = Pack<SANSO_LANES>;

inline P load(const double* p) { return P(*reinterpret_cast<const P::Lanes*>(p)); }
inline void store(P a, double* p) { *reinterpret_cast<P::Lanes*>(p) = a.v; }

/// A group of lanes in registers.
struct Group {
  P x[kNx], u[kNu], next[kNx];
  Group(const StateLanes& xs, const InputLanes& us, int first) {
    for (int i = 0; i < kNx; ++i) x[i] = load(&xs.v[i][first]);
    for (int i = 0; i < kNu; ++i) u[i] = load(&us.v[i][first]);
  }
  void write(StateLanes& xs, int first) const {
    for (int i = 0; i < kNx; ++i) store(next[i], &xs.v[i][first]);
  }
};

/// `keep` (may be null): the first `kept` lanes' steps for their neighbours; one substep only.
void step_group(const StepModel& model, const Ground& ground, const StateLanes& x, const InputLanes& u,
                const BatchStep& step, StateLanes& x_next, ContactLanes* contact, NominalStep* keep, int kept) {
  for (int first = 0; first < kLanes; first += SANSO_LANES) {
    Group g(x, u, first);
    StepScratch<P> scratch;
    P* lambda = &scratch.lambda[0][0][0];
    scratch.warm_start = step.warm_start && contact;
    if (scratch.warm_start)
      for (int i = 0; i < kNumContactRows; ++i) lambda[i] = load(&contact->v[i][first]);
    if (keep && first < kept) {
      StepWork<P> w;
      ContactSlope<P> slope;
      single_step(model, ground, g.x, g.u, step.h, g.next, scratch, w);
      contact_slope(model, step.h, w, scratch, slope);
      for (int lane = 0; lane < SANSO_LANES && first + lane < kept; ++lane)
        keep_nominal(model, w, scratch, slope, g.x, g.u, step.h, lane, keep[first + lane]);
    } else {
      analytical_step(model, ground, g.x, g.u, step.h, step.substeps, g.next, scratch);
    }
    g.write(x_next, first);
    if (contact)
      for (int i = 0; i < kNumContactRows; ++i) store(lambda[i], &contact->v[i][first]);
  }
}

void neighbour_group(const StepModel& model, const NominalStep& nominal, const StateLanes& x, const InputLanes& u, double h,
                     StateLanes& x_next) {
  for (int first = 0; first < kLanes; first += SANSO_LANES) {
    Group g(x, u, first);
    neighbour_step(model, nominal, g.x, g.u, h, g.next);
    g.write(x_next, first);
  }
}

void held_group(const StepModel& model, const Ground& ground, const NominalStep& nominal, const StateLanes& x,
                const InputLanes& u, double h, StateLanes& x_next) {
  for (int first = 0; first < kLanes; first += SANSO_LANES) {
    Group g(x, u, first);
    held_step(model, ground, nominal, g.x, g.u, h, g.next);
    g.write(x_next, first);
  }
}

}  // namespace sanso::model::SANSO_ISA
