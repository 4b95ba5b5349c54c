// Body of one instruction set's copy of the batch step. Include once in a .cpp that defines
// SANSO_ISA and SANSO_LANES.
#include "shared/model/kernel/neighbour.h"
#include "shared/model/step_batch.h"

namespace sanso::model::SANSO_ISA {

/// W doubles from p on, aligned to W doubles.
template <int W>
inline Pack<W> load(const double* p) {
  return Pack<W>(*reinterpret_cast<const typename Pack<W>::Lanes*>(p));
}
/// To W doubles from p on, aligned.
template <int W>
inline void store(Pack<W> a, double* p) {
  *reinterpret_cast<typename Pack<W>::Lanes*>(p) = a.v;
}

/// W lanes in registers, from `first` on of memory with Count.
template <int W>
struct Group {
  Pack<W> x[kNx], u[kNu], next[kNx];
  template <int Count>
  Group(const StatesOf<Count>& xs, const InputsOf<Count>& us, int first) {
    for (int i = 0; i < kNx; ++i) x[i] = load<W>(&xs.v[i][first]);
    for (int i = 0; i < kNu; ++i) u[i] = load<W>(&us.v[i][first]);
  }
  template <int Count>
  void write(StatesOf<Count>& xs, int first) const {
    for (int i = 0; i < kNx; ++i) store(next[i], &xs.v[i][first]);
  }
};

/// `keep` (may be null): the first `kept` lanes' steps for their neighbours; one substep only.
template <int Count>
inline void step_lanes(const StepModel& model, const Ground& ground, const StatesOf<Count>& x,
                       const InputsOf<Count>& u, const BatchStep& step, StatesOf<Count>& x_next,
                       ContactsOf<Count>* contact, NominalStep* keep, int kept) {
  // NOLINTNEXTLINE(bugprone-branch-clone): the macro may be the same number as Count
  constexpr int W = SANSO_LANES < Count ? SANSO_LANES : Count;
  using P = Pack<W>;
  for (int first = 0; first < Count; first += W) {
    Group<W> g(x, u, first);
    StepScratch<P> scratch;
    P* lambda = &scratch.lambda[0][0][0];
    scratch.warm_start = step.warm_start && contact;
    if (scratch.warm_start)
      for (int i = 0; i < kNumContactRows; ++i) lambda[i] = load<W>(&contact->v[i][first]);
    if (keep && first < kept) {
      StepWork<P> w;
      ContactSlope<P> slope;
      P middle[kNx];
      drift(g.x, 0.5 * step.h, middle);
      single_step(model, ground, g.x, g.u, step.h, g.next, scratch, w);
      contact_slope(model, step.h, w, scratch, slope);
      for (int lane = 0; lane < W && first + lane < kept; ++lane)
        keep_nominal(model, w, scratch, slope, middle, g.u, step.h, lane, keep[first + lane]);
    } else {
      analytical_step(model, ground, g.x, g.u, step.h, step.substeps, g.next, scratch);
    }
    g.write(x_next, first);
    if (contact)
      for (int i = 0; i < kNumContactRows; ++i) store(lambda[i], &contact->v[i][first]);
  }
}

/// Eight states at once; `keep`: what neighbours of the first `kept` lanes begin from.
void step_group(const StepModel& model, const Ground& ground, const StateLanes& x,
                const InputLanes& u, const BatchStep& step, StateLanes& x_next,
                ContactLanes* contact, NominalStep* keep, int kept) {
  step_lanes(model, ground, x, u, step, x_next, contact, keep, kept);
}

/// The same for four.
void step_four(const StepModel& model, const Ground& ground, const StateQuad& x, const InputQuad& u,
               const BatchStep& step, StateQuad& x_next, ContactQuad* contact) {
  step_lanes(model, ground, x, u, step, x_next, contact, nullptr, 0);
}

/// States near a solved one that differ in height, velocities and inputs (kernel/neighbour.h).
void neighbour_group(const StepModel& model, const NominalStep& nominal, const StateLanes& x,
                     const InputLanes& u, double h, StateLanes& x_next) {
  for (int first = 0; first < kLanes; first += SANSO_LANES) {
    Group<SANSO_LANES> g(x, u, first);
    neighbour_step(model, nominal, g.x, g.u, h, g.next);
    g.write(x_next, first);
  }
}

/// States near a solved one that differ in anything.
void held_group(const StepModel& model, const Ground& ground, const NominalStep& nominal,
                const StateLanes& x, const InputLanes& u, double h, StateLanes& x_next) {
  for (int first = 0; first < kLanes; first += SANSO_LANES) {
    Group<SANSO_LANES> g(x, u, first);
    held_step(model, ground, nominal, g.x, g.u, h, g.next);
    g.write(x_next, first);
  }
}

}  // namespace sanso::model::SANSO_ISA
