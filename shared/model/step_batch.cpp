// Picks the widest instruction set that the machine has and hands every group of lanes to the
// kernel that was built for it.
#include "shared/model/step_batch.h"

#include <atomic>
#include <cstring>

namespace sanso::model {

using GroupStep = void (*)(const StepModel&, const Ground&, const StateLanes&, const InputLanes&,
                           const BatchStep&, StateLanes&, ContactLanes*, NominalStep*, int);
using QuadStep = void (*)(const StepModel&, const Ground&, const StateQuad&, const InputQuad&,
                          const BatchStep&, StateQuad&, ContactQuad*);
using NeighbourStep = void (*)(const StepModel&, const NominalStep&, const StateLanes&,
                               const InputLanes&, double, StateLanes&);
using HeldStep = void (*)(const StepModel&, const Ground&, const NominalStep&, const StateLanes&,
                          const InputLanes&, double, StateLanes&);
#define SANSO_DECLARE_GROUP_STEP(isa)                                                              \
  namespace isa {                                                                                  \
  void step_group(const StepModel&, const Ground&, const StateLanes&, const InputLanes&,           \
                  const BatchStep&, StateLanes&, ContactLanes*, NominalStep*, int);                \
  void step_four(const StepModel&, const Ground&, const StateQuad&, const InputQuad&,              \
                 const BatchStep&, StateQuad&, ContactQuad*);                                      \
  void neighbour_group(const StepModel&, const NominalStep&, const StateLanes&, const InputLanes&, \
                       double, StateLanes&);                                                       \
  void held_group(const StepModel&, const Ground&, const NominalStep&, const StateLanes&,          \
                  const InputLanes&, double, StateLanes&);                                         \
  }
SANSO_DECLARE_GROUP_STEP(baseline)
#ifdef SANSO_HAVE_X86_UNITS
SANSO_DECLARE_GROUP_STEP(avx2)
SANSO_DECLARE_GROUP_STEP(avx512)
#endif

namespace {

struct Unit {
  const char* name;
  GroupStep step;
  QuadStep four;
  NeighbourStep neighbours;
  HeldStep held;
  bool (*runs_here)();
};

constexpr Unit kUnits[] = {
#ifdef SANSO_HAVE_X86_UNITS
    {"avx512", avx512::step_group, avx512::step_four, avx512::neighbour_group, avx512::held_group,
     [] {
       return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
              __builtin_cpu_supports("fma");
     }},
    {"avx2", avx2::step_group, avx2::step_four, avx2::neighbour_group, avx2::held_group,
     [] { return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"); }},
#endif
    {"portable", baseline::step_group, baseline::step_four, baseline::neighbour_group,
     baseline::held_group, [] { return true; }},
};

const Unit* best_unit() {
  for (const Unit& unit : kUnits)
    if (unit.runs_here()) return &unit;
  return nullptr;  // never: the last unit runs everywhere
}

std::atomic<const Unit*> active_unit{best_unit()};

}  // namespace

void step_batch(const StepModel& model, const Ground& ground, const StateLanes* x,
                const InputLanes* u, const BatchStep& step, StateLanes* x_next,
                ContactLanes* contact, int groups) {
  const GroupStep run = active_unit.load(std::memory_order_relaxed)->step;
  for (int g = 0; g < groups; ++g)
    run(model, ground, x[g], u[g], step, x_next[g], contact ? contact + g : nullptr, nullptr, 0);
}

void step_quad(const StepModel& model, const Ground& ground, const StateQuad& x, const InputQuad& u,
               const BatchStep& step, StateQuad& x_next, ContactQuad* contact) {
  active_unit.load(std::memory_order_relaxed)->four(model, ground, x, u, step, x_next, contact);
}

void step_batch_keep(const StepModel& model, const Ground& ground, const StateLanes& x,
                     const InputLanes& u, const BatchStep& step, StateLanes& x_next,
                     ContactLanes* contact, NominalStep* lanes, int kept) {
  active_unit.load(std::memory_order_relaxed)
      ->step(model, ground, x, u, step, x_next, contact, lanes, kept);
}

void step_held(const StepModel& model, const Ground& ground, const NominalStep& nominal,
               const StateLanes* x, const InputLanes* u, double h, StateLanes* x_next, int groups) {
  const HeldStep run = active_unit.load(std::memory_order_relaxed)->held;
  for (int g = 0; g < groups; ++g) run(model, ground, nominal, x[g], u[g], h, x_next[g]);
}

void step_neighbours(const StepModel& model, const NominalStep& nominal, const StateLanes* x,
                     const InputLanes* u, double h, StateLanes* x_next, int groups) {
  const NeighbourStep run = active_unit.load(std::memory_order_relaxed)->neighbours;
  for (int g = 0; g < groups; ++g) run(model, nominal, x[g], u[g], h, x_next[g]);
}

const char* batch_isa() { return active_unit.load(std::memory_order_relaxed)->name; }

bool select_batch_isa(const char* name) {
  for (const Unit& unit : kUnits)
    if (std::strcmp(unit.name, name) == 0 && unit.runs_here()) {
      active_unit.store(&unit, std::memory_order_relaxed);
      return true;
    }
  return false;
}

}  // namespace sanso::model
