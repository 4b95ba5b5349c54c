// A motion on the planner's own model of the robot: plan, guard, and the model at 2 ms. What a
// robot would do that is as it is believed to be.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>

#include "host/model/augmented_model.h"
#include "host/mpc/cost.h"
#include "host/mpc/mpc_settings.h"
#include "host/mpc/plan_result.h"
#include "host/mpc/upper_layer.h"
#include "shared/base/time.h"

namespace sanso::motion {

/// The planner, how often it is asked, and what the controller lets through.
struct StageSettings {
  mpc::MpcSettings planner;
  int ticks_per_plan = 6;
  double target_rate_rad_s = 60.0;
  double target_offset_rad = 0.6;
};

class ModelStage {
 public:
  static constexpr int kStepsPerTick = 5;
  static constexpr double kStep_s = kTick_s / kStepsPerTick;
  /// Normal forces of the soles, right and left, N.
  using Loads = std::array<double, 2>;

  /// Begins at the reference's first state, at rest. `reference`, one a tick, must outlive the
  /// stage.
  ModelStage(std::span<const model::State> reference, const mpc::CostWeights& weights,
             const host::AugmentedModel& model, const StageSettings& settings);

  /// New targets for this tick; false when the planner has no answer.
  bool tell(int tick);
  /// One tick of the model; `look` after each of its steps, `kStep_s` apart.
  void move(const std::function<void(int step, const Loads& loads)>& look);

  const model::State& state() const { return x_; }
  const model::Input& targets() const { return u_; }
  /// What the planner added to the reference's joints, before the guard.
  const model::Input& upper() const { return upper_; }

 private:
  std::span<const model::State> reference_;
  StageSettings settings_;
  host::AugmentedModel model_;
  mpc::UpperLayer planner_;
  std::unique_ptr<mpc::PlanResult> plan_ = std::make_unique<mpc::PlanResult>();
  std::unique_ptr<policy::Knot> knot_ = std::make_unique<policy::Knot>();
  model::State x_;
  model::Input u_, upper_ = model::Input::Zero();
};

}  // namespace sanso::motion
