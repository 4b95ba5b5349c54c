// Equations of motion of a tree of one-degree-of-freedom joints on a fixed base: M(q) ddq + bias(q,
// dq) = tau.
// Everything is expressed in base axes about the base origin, so composite bodies add up without
// transforms.
// Kept apart from shared/model on purpose: joints may slide, any figure may be changed by an effect
// between two calls, and branches that only meet at the base (two legs in a stand) are solved one
// by one.
#pragma once

#include <array>
#include <vector>

#include "tools/diagnose/model_folder/robot_tree.h"

namespace sanso::diagnose {

/// Square matrix of up to kMaxJoints rows; entry (i, j) at [i * kMaxJoints + j].
using JointMatrix = std::array<double, kMaxJoints * kMaxJoints>;
using JointVector = std::array<double, kMaxJoints>;

class TreeDynamics {
 public:
  /// gravity: acceleration of free fall in base axes, m/s^2.
  TreeDynamics(const RobotTree& tree, const Vec3& gravity);

  int size() const { return n_; }
  /// Joints [branch_begin(b), branch_begin(b + 1)) hang on the base by themselves: M has no entries
  /// across branches.
  int branches() const { return static_cast<int>(branch_begin_.size()) - 1; }
  int branch_begin(int b) const { return branch_begin_[static_cast<std::size_t>(b)]; }

  /// Frames, axes and inertias at joint positions q (n). First call of every step; of one branch,
  /// or of all.
  void set_positions(const double* q, int branch);
  void set_positions(const double* q);
  /// Lower triangle and diagonal of M, kg m^2 (kg).
  void mass_matrix(JointMatrix& M, int branch) const;
  void mass_matrix(JointMatrix& M) const;
  /// Gravity, centrifugal and Coriolis torques at velocities dq (n); also minus the torques of
  /// world_force().
  void bias(const double* dq, JointVector& h, int branch) const;
  void bias(const double* dq, JointVector& h) const;
  /// Torques that move the joints with acceleration ddq: M ddq + bias.
  void inverse_dynamics(const double* dq, const double* ddq, JointVector& tau) const;

  /// A force in base axes at the centre of mass of the link behind joint j, N; stays until changed.
  void set_world_force(int j, const Vec3& force) {
    force_[static_cast<std::size_t>(j)] = force, any_force_ = true;
  }
  void add_world_force(int j, const Vec3& force) {
    Vec3& f = force_[static_cast<std::size_t>(j)];
    f = f + force;
    any_force_ = true;
  }
  /// Base frame position of the joint's origin / of its link's centre of mass, m.
  const Vec3& origin(int j) const { return frame_[static_cast<std::size_t>(j)].p; }
  const Vec3& com(int j) const { return frame_[static_cast<std::size_t>(j)].com; }

 private:
  struct Constant {  // of one joint, joint axes
    int parent;
    bool prismatic;
    std::array<double, 9> A, B, C;  // R_parent_link(q) = A + sin(q) B + cos(q) C
    Vec3 p_parent_joint, axis_parent, axis_joint;
    double mass;
    Vec3 com;
    std::array<double, 6> I;  // about the centre of mass: xx yy zz xy xz yz
  };
  struct Frame {  // of one link, base axes
    std::array<double, 9> R;
    Vec3 p, com;
    Vec3 s_ang, s_lin;  // motion of the joint as a spatial vector about the base origin
  };
  struct Inertia {  // spatial inertia about the base origin, base axes
    double m;
    Vec3 mc;  // first moment
    std::array<double, 6> I;
  };

  void set_frames(const double* q, int begin, int end);
  template <bool kWithAcceleration>
  void recursive_newton_euler(const double* dq, const double* ddq, JointVector& tau, int begin,
                              int end) const;

  int n_;
  Vec3 gravity_;
  std::vector<int> branch_begin_;
  std::array<int, kMaxJoints> root_{};  // first joint of the branch a joint belongs to
  std::array<Constant, kMaxJoints> constant_{};
  std::array<Frame, kMaxJoints> frame_{};
  std::array<Inertia, kMaxJoints> inertia_{};
  std::array<Vec3, kMaxJoints> force_{};
  bool any_force_ = false;
  // one revolute joint alone: its inertia is constant and gravity's torque is pull_sine_ sin q +
  // pull_cosine_ cos q
  bool lone_hinge_ = false;
  double lone_inertia_ = 0.0, pull_sine_ = 0.0, pull_cosine_ = 0.0;  // kg m^2, N m, N m
  double lone_q_ = 0.0;                                              // rad
};

}  // namespace sanso::diagnose
