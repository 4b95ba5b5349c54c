// The solver's phases for the OP3: learned whole-body model, sum of the layers, tracking cost.
// Derivatives are forward differences in SIMD lanes (why: docs/decisions), the residual network's
// part and the other layers' part are exact.
#pragma once

#include <atomic>
#include <memory>

#include "host/model/augmented_model.h"
#include "host/mpc/lane_kernels.h"
#include "host/mpc/spin_pool.h"
#include "shared/model/step_batch.h"

namespace sanso::mpc {

struct Op3PhasesSettings {
  int horizon = 12;
  double dt_s = 0.06;
  double difference_step = 1e-6;
  // differences about the nominal step, its contact set held (false: for comparison)
  bool share_nominal_step = true;
};

class Op3Phases : public Phases {
 public:
  Op3Phases(const Op3PhasesSettings& settings, const host::AugmentedModel& model, SpinPool& pool,
            const LaneKernels& kernels = lane_kernels());

  void set_model(const host::AugmentedModel& model);
  /// Filled by the caller before every solve.
  ProblemContext& context() { return work_->context; }
  const ResidualWeights* residual() const {
    return work_->residual.present ? &work_->residual : nullptr;
  }

  /// Of the last linearisation: what the analytical step comes to at a stage's nominal point.
  model::State nominal_next(int stage) const;
  /// Contact forces that start the next linearisation, from other phases of the same trajectory.
  void start_contact_from(const Op3Phases& other);

  int stages() const override { return settings_.horizon - 1; }
  void begin_solve() override;
  void linearize(const Trajectory& nominal, StageDerivatives* derivatives,
                 StageCost* costs) override;
  void begin_linearize(const Trajectory& nominal, StageDerivatives* derivatives,
                       StageCost* costs) override;
  void wait_for(int stage) override;
  void finish_linearize() override { pool_.finish(); }
  void roll_out(const LinePolicy& policy, const double* steps, LaneTrajectories& out) override;
  void lane_taken(int lane) override;

 private:
  enum Whole { kNominal, kWithoutUpper, kAlongX, kWholeSteps };
  static constexpr int kStageGroups = (kMaxStages + model::kLanes - 1) / model::kLanes;
  /// Pieces of work of begin_linearize: a stage each.
  struct StageWork {
    Op3Phases* phases;
    const Trajectory* nominal;
    StageDerivatives* derivatives;
    StageCost* costs;
    void operator()(int item, int thread) const;
  };
  struct Nominal {  // of one stage
    double u_total[kNuPadded], u_without_upper[kNuPadded];
    double layer_slope[kNu][kNdxPadded];  // d (middle + reflex) / dx
  };
  struct Workspace {
    ProblemContext context;
    ResidualWeights residual;
    StageEvaluations evaluations[kMaxStages];
    Nominal nominal[kMaxStages];
    model::NominalStep step[kMaxStages];
    model::ContactQuad rolled_contact[kRollOutGroups][kMaxStages];  // of the last roll-out
    KeptJacobian jacobian[kMaxStages];
    double nominal_contact[kMaxStages][model::kNumContactRows];
    // whole steps of all stages side by side, lane = stage: the nominal point, without u_up, and
    // farther along base x
    model::StateLanes whole_x[kWholeSteps][kStageGroups];
  };

  void roll_out_group(const LinePolicy& policy, const double* steps, int group, LaneGroup& out);
  void prepare_stage(const Trajectory& nominal, int stage);
  void evaluate_whole(const Trajectory& nominal, int item);
  void evaluate_stage(const double* x_nominal, int stage);
  void finish_stage(const StageWork& of, int stage);
  bool ground_varies() const;
  int stage_groups() const { return (stages() + model::kLanes - 1) / model::kLanes; }
  bool shares() const { return settings_.share_nominal_step && model_.substeps == 1; }

  Op3PhasesSettings settings_;
  host::AugmentedModel model_;
  SpinPool& pool_;
  const LaneKernels& kernels_;
  std::unique_ptr<Workspace> work_;
  StageWork stages_{};
  std::atomic<bool> stage_done_[kMaxStages] = {};
};

/// Second-order model of ||x ⊖ x_ref||²_Wx (and of ||u||²_Wu when u is given) on the tangent at x.
void cost_model(const ProblemContext& context, int knot, const double* x, const double* u,
                StageCost& out);

}  // namespace sanso::mpc
