// The whole-body step for groups of eight or four states at once. Memory is the same on every
// machine (structure of arrays); the instructions are chosen at run time: AVX-512, AVX2 or the
// baseline of the build.
#pragma once

#include "shared/model/ground.h"
#include "shared/model/nominal_step.h"
#include "shared/model/step_model.h"

namespace sanso::model {

inline constexpr int kLanes = 8, kQuadLanes = 4;

/// `Count` states, inputs, contact solutions: [component][lane].
template <int Count>
struct alignas(8 * Count) StatesOf {
  double v[kNx][Count];
};
template <int Count>
struct alignas(8 * Count) InputsOf {
  double v[kNu][Count];
};
/// Contact impulses [N s], order foot, corner, (forward, across, normal).
template <int Count>
struct alignas(8 * Count) ContactsOf {
  double v[kNumContactRows][Count];
};

using StateLanes = StatesOf<kLanes>;
using InputLanes = InputsOf<kLanes>;
using ContactLanes = ContactsOf<kLanes>;
using StateQuad = StatesOf<kQuadLanes>;
using InputQuad = InputsOf<kQuadLanes>;
using ContactQuad = ContactsOf<kQuadLanes>;

struct BatchStep {
  double h;                 // s
  int substeps = 1;         // equal parts of h
  bool warm_start = false;  // begin the contact solver from `contact`; otherwise from zero
};

/// x_next[g] = f_A(x[g], u[g]) for `groups` groups of eight lanes; bounded work, no allocation,
/// safe from several threads on disjoint groups. `contact` (may be null when not warm_start)
/// receives the impulses of the last substep.
/// Arrays are aligned to 64 bytes; x_next may alias x.
void step_batch(const StepModel& model, const Ground& ground, const StateLanes* x,
                const InputLanes* u, const BatchStep& step, StateLanes* x_next,
                ContactLanes* contact, int groups);

/// The same for four lanes: more work a lane than in groups of eight where registers hold eight,
/// but two threads can share eight lanes, and a lane waits for three others instead of seven.
void step_quad(const StepModel& model, const Ground& ground, const StateQuad& x, const InputQuad& u,
               const BatchStep& step, StateQuad& x_next, ContactQuad* contact);

/// One group in one substep (step.substeps is not read); keeps the steps of the first `kept` lanes
/// for states nearby.
void step_batch_keep(const StepModel& model, const Ground& ground, const StateLanes& x,
                     const InputLanes& u, const BatchStep& step, StateLanes& x_next,
                     ContactLanes* contact, NominalStep* lanes, int kept);

/// Steps of states near the kept one, right to first order in the difference, with the contact set
/// held (kernel/neighbour.h): for derivatives by differences. Same alignment rules as step_batch.
void step_held(const StepModel& model, const Ground& ground, const NominalStep& nominal,
               const StateLanes* x, const InputLanes* u, double h, StateLanes* x_next, int groups);
/// The same for states that differ in height, velocities and inputs only, at a fraction of the
/// work.
void step_neighbours(const StepModel& model, const NominalStep& nominal, const StateLanes* x,
                     const InputLanes* u, double h, StateLanes* x_next, int groups);

/// What step_batch uses on this machine: "avx512", "avx2" or "portable".
const char* batch_isa();
/// For tests and benchmarks: use this one instead. False (and no change) when the machine or the
/// build lacks it.
bool select_batch_isa(const char* name);

}  // namespace sanso::model
