// The peer: the same planning problem on MuJoCo. Same figures, servo, horizon, cost, step lengths
// and stopping rule; its derivatives are mjd_transitionFD, its contact is MuJoCo's. It runs through
// our Solver, so that it also profits from our backward pass: what is compared is the model and its
// derivatives. It has no residual network and no noise term, an easier problem than ours.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <string>
#include <vector>

#include "host/model/augmented_model.h"
#include "host/mpc/phases.h"
#include "host/mpc/spin_pool.h"
#include "host/mpc/stage_context.h"

namespace sanso::bench {

/// MJCF of the twelve-joint OP3 with the servos of `model` made implicit: armature + h D + h^2 K on
/// the diagonal and the force K (u - q) - (D + h K) v, which in MuJoCo's Euler step is the same
/// implicit spring and damper as ours.
std::string peer_mjcf(const model::ModelParameters& theta, double timestep_s);

class MujocoPhases : public mpc::Phases {
 public:
  MujocoPhases(int horizon, double dt_s, double difference_step, mpc::SpinPool& pool);
  ~MujocoPhases() override;
  MujocoPhases(const MujocoPhases&) = delete;
  MujocoPhases& operator=(const MujocoPhases&) = delete;

  mpc::ProblemContext& context() { return *context_; }
  int stages() const override { return horizon_ - 1; }
  void linearize(const mpc::Trajectory& nominal, mpc::StageDerivatives* derivatives,
                 mpc::StageCost* costs) override;
  void roll_out(const mpc::LinePolicy& policy, const double* steps,
                mpc::LaneTrajectories& out) override;

  /// One 60 ms step from x with the targets u; for tests and for the time of a step.
  void step(const double* x, const double* u, double* x_next, int thread = 0);

 private:
  void linearize_stage(const mpc::Trajectory& nominal, int stage, int thread,
                       mpc::StageDerivatives& out);
  void roll_out_lane(const mpc::LinePolicy& policy, double step_length, int lane, int thread,
                     mpc::LaneTrajectories& out);
  void set(mjData* data, const double* x, int stage, const double* u_upper) const;

  int horizon_;
  double difference_step_;
  mpc::SpinPool& pool_;
  mjModel* model_ = nullptr;
  std::vector<mjData*> data_;               // one per thread
  std::vector<std::vector<mjtNum>> A_, B_;  // row-major, one per thread
  std::unique_ptr<mpc::ProblemContext> context_;
};

}  // namespace sanso::bench
