// Equations of motion of a tree of one-degree-of-freedom joints on a fixed base: M(q) ddq + bias(q,
// dq) = tau.
// Everything is expressed in base axes about the base origin, so composite bodies add up without
// transforms.
// Kept apart from shared/model on purpose: joints may slide, any figure may be changed by an effect
// between two calls, and branches that only meet at the base (two legs in a stand) are solved one
// by one. The equations are those of tree.h, here for one robot.
#pragma once

#include <array>

#include "tools/diagnose/sim/tree.h"

namespace sanso::diagnose {

/// Square matrix of up to kMaxJoints rows; entry (i, j) at [i * kMaxJoints + j].
using JointMatrix = std::array<double, kMaxJoints * kMaxJoints>;
using JointVector = std::array<double, kMaxJoints>;

class TreeDynamics {
 public:
  /// gravity: acceleration of free fall in base axes, m/s^2.
  TreeDynamics(const RobotTree& tree, const Vec3& gravity)
      : n_(tree.size()), tree_(tree_figures(tree, gravity)) {}

  std::size_t size() const { return n_; }

  /// Frames, axes and inertias at joint positions q (n). First call of every step.
  void set_positions(const double* q);
  /// Lower triangle and diagonal of M, kg m^2 (kg); no entries across branches.
  void mass_matrix(JointMatrix& M) const;
  /// Gravity, centrifugal and Coriolis torques at velocities dq (n); also minus the torques of
  /// world forces.
  void bias(const double* dq, JointVector& h) const;
  /// Torques that move the joints with acceleration ddq: M ddq + bias.
  void inverse_dynamics(const double* dq, const double* ddq, JointVector& tau) const;

  /// A force in base axes at the centre of mass of the link behind joint j, N; stays until changed.
  void set_world_force(std::size_t j, const Vec3& force);
  void add_world_force(std::size_t j, const Vec3& force);
  /// Base frame position of the joint's origin / of its link's centre of mass, m.
  Vec3 origin(std::size_t j) const { return plain(tree_.origin(j)); }
  Vec3 com(std::size_t j) const { return plain(tree_.com(j)); }

 private:
  static Vec3 plain(const portable::V3<double>& v) { return {v[0], v[1], v[2]}; }

  std::size_t n_;
  portable::Tree<double> tree_;
  std::array<Vec3, kMaxJoints> force_{};
};

}  // namespace sanso::diagnose
