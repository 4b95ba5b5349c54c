// Any robot that is a tree of one-degree-of-freedom joints, on a fixed or a floating base:
// kinematics, inverse and forward dynamics, Jacobians, energy. Size known at run time, storage
// fixed: no heap. The controlled OP3 has its own, faster code (op3_step.h); this one serves every
// other robot and is the second witness for it.
//
// Coordinates    q = [p_world_base 3 | quat_world_base 4 | joints n] (floating), [joints n] (fixed)
// Velocity       v = [v_base_in_world 3 | w_base_in_base 3 | joint rates n], or [joint rates n]:
// MuJoCo's qpos, qvel.
// Forces         dual to v: base force in world axes, base moment in base axes, joint torques (N m)
// or forces (N).
#pragma once

#include <Eigen/Core>

#include "shared/base/fixed_vector.h"
#include "shared/base/status.h"
#include "shared/math/so3.h"

namespace sanso::model {

using math::Mat3;
using math::Vec3;

inline constexpr int kMaxTreeJoints = 32;
inline constexpr int kMaxTreeNv = kMaxTreeJoints + 6;

/// Mass properties of a link: mass kg; centre of mass from the link's origin, m, link axes;
/// rotational inertia about the centre of mass, kg m^2, link axes.
struct LinkInertia {
  double mass = 0.0;
  Vec3 com = Vec3::Zero();
  Mat3 about_com = Mat3::Zero();
};

/// Two rigidly joined bodies as one, both given in the same axes from the same origin.
LinkInertia combined(const LinkInertia& a, const LinkInertia& b);

enum class JointKind : std::uint8_t { revolute, prismatic };

/// A joint and the link that it moves. At joint position 0 the link's frame is fixed in its parent
/// at (R, p).
struct TreeJoint {
  int parent = -1;  // index of the parent joint's link, smaller than its own; -1 = base
  JointKind kind = JointKind::revolute;
  Mat3 R_parent_link0 = Mat3::Identity();
  Vec3 p_parent_link0 = Vec3::Zero();  // m
  Vec3 axis = Vec3::UnitZ();           // unit, link axes
  LinkInertia link;
  double armature = 0.0;  // reflected rotor inertia on the diagonal of M, kg m^2 (or kg)
};

struct Tree {
  bool floating = false;
  LinkInertia base;               // used when floating
  Vec3 gravity{0.0, 0.0, -9.81};  // m/s^2, world axes
  FixedVector<TreeJoint, kMaxTreeJoints> joints;

  int num_joints() const { return static_cast<int>(joints.size()); }
  int nq() const { return num_joints() + (floating ? 7 : 0); }
  int nv() const { return num_joints() + (floating ? 6 : 0); }
  int first_joint_v() const { return floating ? 6 : 0; }
};

using TreeVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxTreeNv + 1, 1>;
using TreeMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxTreeNv, kMaxTreeNv>;
using TreeJacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMaxTreeNv>;

/// Where everything is; entry 0 is the base, entry i + 1 the link of joint i. World axes.
struct TreeKinematics {
  std::array<Mat3, kMaxTreeJoints + 1> R_world_link;
  std::array<Vec3, kMaxTreeJoints + 1> p_world_link;
  std::array<Vec3, kMaxTreeJoints + 1> axis_world;  // of the joint that moves the link
};

/// Scratch of the algorithms; one per thread. Contents between calls are of no interest.
struct TreeScratch {
  TreeKinematics kin;
  std::array<Vec3, kMaxTreeJoints + 1> w, v, dw, dv;   // of the link's origin, world axes
  std::array<Vec3, kMaxTreeJoints + 1> force, moment;  // on the link; moment about its origin
  std::array<double, kMaxTreeJoints + 1> mass;         // composite bodies
  std::array<Vec3, kMaxTreeJoints + 1> com;
  std::array<Mat3, kMaxTreeJoints + 1> inertia;
  TreeMatrix M;
  TreeVector bias;
};

/// Positions and axes of all links for q (nq).  Cost O(n).
void forward_kinematics(const Tree& tree, const TreeVector& q, TreeKinematics& out);

/// Inverse dynamics: generalised forces (nv) that make `dv` (nv) happen in (q, v).   [Featherstone
/// 2008, ch. 5]
void rnea(const Tree& tree, const TreeVector& q, const TreeVector& v, const TreeVector& dv,
          TreeScratch& scratch, TreeVector& tau);

/// Joint-space inertia M(q) (nv x nv), symmetric, armature included.   [Featherstone 2008, ch. 6]
void crba(const Tree& tree, const TreeVector& q, TreeScratch& scratch, TreeMatrix& M);

/// Accelerations (nv) under generalised forces tau (nv): M dv = tau - bias. not_ready when M is not
/// positive definite (a link without mass and armature).
Status forward_dynamics(const Tree& tree, const TreeVector& q, const TreeVector& v,
                        const TreeVector& tau, TreeScratch& scratch, TreeVector& dv);

/// Jacobians of a point fixed to link `link` (-1 = base), given in link axes: v -> velocity of the
/// point and angular velocity of the link, both in world axes. Needs forward_kinematics.
void point_jacobian(const Tree& tree, const TreeKinematics& kin, int link, const Vec3& p_link_point,
                    TreeJacobian& linear, TreeJacobian& angular);

/// Kinetic energy 1/2 v' M v and potential energy -sum m g . p_com, J.
struct TreeEnergy {
  double kinetic = 0, potential = 0;
};
TreeEnergy energy(const Tree& tree, const TreeVector& q, const TreeVector& v, TreeScratch& scratch);

/// q after moving with the constant velocity v for `dt` seconds (base orientation by the
/// exponential map).
TreeVector integrate(const Tree& tree, const TreeVector& q, const TreeVector& v, double dt);

}  // namespace sanso::model
