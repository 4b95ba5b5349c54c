// The upper layer as the session sees it: a trial's context once, then one plan per upper period.
// Everything is allocated at construction; plan() allocates nothing and returns before its deadline with the best
// policy found so far. Not thread-safe: one caller (which is also the first of the solver's threads).
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "host/model/augmented_model.h"
#include "host/mpc/cost.h"
#include "host/mpc/mpc_settings.h"
#include "host/mpc/plan_result.h"
#include "shared/base/status.h"
#include "shared/base/time.h"
#include "shared/policy/layer_sum.h"

namespace sanso::mpc {

/// What stays the same during a trial. The spans and the table must outlive the trial; nothing is copied.
struct TrialContext {
  std::uint32_t trial_id = 0;
  std::span<const model::State> reference;       // x_DMP, one per 10 ms tick from trial tick 0; held after its end.
                                                 // Its joint angles are the primitives' input (paper: u_DMP = q2_DMP).
  const policy::MiddleTable* middle = nullptr;   // null or empty: the middle layer is off
  policy::LayerSwitches on;                      // as the controller runs (upper: false plans all the same)
  policy::ReflexSettings reflex;
  model::Input u_rest = model::Input::Zero();    // target in place of the primitives when the lower layer is off, rad
  CostWeights weights;
};

/// What one plan starts from.
struct PlanRequest {
  std::int32_t observed_tick = 0;                     // trial tick at which x_observed was true
  model::State x_observed = model::neutral_state();
  std::int32_t plan_tick = 0;                         // trial tick of the policy's first knot, >= observed_tick
  const policy::UpperPolicy* in_use = nullptr;        // what the controller runs until plan_tick; null: nothing
  std::uint32_t sequence = 0;                         // goes into the policy
  double sigma = -1.0;                                // noise amplitude; negative: the setting's
  Nanoseconds time_budget = 0;                        // from the call of plan(); 0: none
};

struct PlanResult {
  Status status = Status::not_ready;  // ok, or out_of_range when the state or the roll-out is not finite
  policy::UpperPolicy policy;         // kMaxUpperKnots knots (u, x, K), first at plan_tick, dt_s apart
  double cost_before = 0;             // deterministic cost of the start: u_up = 0, or the shifted last plan
  double cost_after = 0;              // of the returned policy, same roll-out, same weights
  double gain_norm = 0;               // largest Frobenius norm of the knots' K before the limit
  int iterations = 0;                 // iterations whose step was accepted or that proved convergence
  StopReason stop = StopReason::iteration_limit;
  PlanTiming timing;
  model::State x_plan = model::neutral_state();  // predicted state at plan_tick, where the plan starts
};

class UpperLayer {
 public:
  /// Copies the settings and the model. `threads` - 1 threads start here and end with the object.
  UpperLayer(const MpcSettings& settings, const host::AugmentedModel& model);
  ~UpperLayer();
  UpperLayer(const UpperLayer&) = delete;
  UpperLayer& operator=(const UpperLayer&) = delete;

  /// Takes a newly learned model; between trials, never during plan().
  void set_model(const host::AugmentedModel& model);
  /// Forgets the last plan (warm start) and takes the context of a new trial.
  void begin_trial(const TrialContext& context);
  /// `result` belongs to the caller, so that nothing is returned by value. Fails never for finite input.
  void plan(const PlanRequest& request, PlanResult& result);

  const MpcSettings& settings() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sanso::mpc
