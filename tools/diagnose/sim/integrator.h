// One time step of the whole robot, shared by simulation (the tree moves) and replay (the tree
// follows the recording).
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "tools/diagnose/sim/command_path.h"
#include "tools/diagnose/sim/transmission.h"
#include "tools/diagnose/sim/tree_dynamics.h"

namespace sanso::diagnose {

struct RobotState {
  JointVector q{}, dq{};  // link side, rad, rad/s
  std::array<InnerState, kMaxJoints> inner{};
};

/// Torques of the step just taken, by joint.
struct StepTorques {
  std::array<ServoOutput, kMaxJoints> servo{};
  JointVector friction{}, passive{};  // N m, mean over the step
};

class Integrator {
 public:
  /// wanted: by joint, not 0: its branch is simulated; empty: all. A supply that sags couples all
  /// joints.
  Integrator(const SimParams& params, const Drive& drive, std::uint64_t random_seed,
             const std::vector<char>& wanted = {});

  /// Starts anew at any instant (payloads that come late are looked up for it).
  void restart(double t);
  /// Inner states of servos that held this posture before t (their integral).
  void settle(double t, const std::vector<int>& serves, RobotState& state);
  /// Advances from t by h. False when the motion diverged (state unchanged).
  bool step(double t, double h, RobotState& state, StepTorques& out);
  /// The same with prescribed motion: velocities reach dq_end; only inner states and torques are
  /// computed. The tree's inertia and bias are taken anew every kTreeRefresh seconds only.
  /// `serves`: the joints whose servo and transmission are wanted.
  void follow(double t, double h, const double* dq_end, const std::vector<int>& serves,
              RobotState& state, StepTorques& out);
  /// Joints that are simulated, in order.
  const std::vector<int>& joints() const { return joints_; }

 private:
  void move_tree(double t, double h, const RobotState& state);
  void prepare(double t, double h, const std::vector<int>& serves, RobotState& state,
               StepTorques& out);
  double warming_of(int j, double t, const InnerState& inner) const;
  void update_bodies(double t);
  void solve_free(double h, const RobotState& state);
  void solve_friction();
  void finish(double h, const JointVector& dq_end, const std::vector<int>& serves,
              RobotState& state, StepTorques& out);

  const SimParams& params_;
  const Drive& drive_;
  CommandPath commands_;
  std::unique_ptr<TreeDynamics> tree_;
  int n_;
  std::vector<int> joints_, branches_;  // what is simulated
  int payloads_on_ = -1;
  bool any_sag_;
  bool thermal_;
  std::vector<double> first_temperature_;  // by joint, NaN: none recorded
  mutable std::vector<std::size_t> temperature_cursor_;

  // scratch of the step
  JointMatrix M_{}, inverse_{};
  JointVector bias_{}, q_half_{}, dq_mid_{}, dq_end_{}, change_{}, friction_{};
  std::array<JointPart, kMaxJoints> part_{};
  std::array<JointInstant, kMaxJoints> instant_{};
  double supply_current_ = 0.0;  // A, of the step before
  double tree_time_ = -kNone;    // s, instant of the tree's inertia and bias while following
};

}  // namespace sanso::diagnose
