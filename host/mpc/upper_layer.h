// The upper layer as the session sees it: a trial's context once, then one plan per upper period.
// Everything is allocated at construction; plan() allocates nothing and returns before its deadline
// with the best policy found so far. Not thread-safe: one caller (which is also the first of the
// solver's threads).
#pragma once

#include <memory>

#include "host/model/augmented_model.h"
#include "host/mpc/mpc_settings.h"
#include "host/mpc/plan_request.h"
#include "host/mpc/plan_result.h"
#include "host/mpc/trial_context.h"

namespace sanso::mpc {

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
  /// `result` belongs to the caller, so that nothing is returned by value. Fails never for finite
  /// input.
  void plan(const PlanRequest& request, PlanResult& result);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sanso::mpc
