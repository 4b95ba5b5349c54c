// Figures of a tree, and the equations of tree.h for one robot, all branches.
#include "tools/diagnose/sim/tree_dynamics.h"

#include <algorithm>
#include <cassert>

namespace sanso::diagnose {
namespace {

JointFigures joint_figures(const TreeJoint& joint) {
  JointFigures out;
  out.parent = joint.parent;
  out.prismatic = joint.prismatic;
  std::copy_n(joint.p_parent_joint.begin(), 3, out.p_parent_joint);
  const Vec3 axis = rotated(joint.R_parent_joint, joint.axis);
  std::copy_n(axis.begin(), 3, out.axis_parent);
  // Rodrigues: Rot(a, q) = a a' + cos(q) (1 - a a') + sin(q) [a]x, premultiplied by the fixed
  // rotation
  const Vec3& a = joint.axis;
  Mat3 outer, rest, skew{0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0};
  for (std::size_t r = 0; r < 3; ++r) {
    for (std::size_t s = 0; s < 3; ++s) {
      outer[3 * r + s] = a[r] * a[s];
      rest[3 * r + s] = (r == s ? 1.0 : 0.0) - a[r] * a[s];
    }
  }
  const Mat3 A = product(joint.R_parent_joint, outer), B = product(joint.R_parent_joint, skew),
             C = product(joint.R_parent_joint, rest);
  std::copy_n(A.begin(), 9, out.A);
  std::copy_n(B.begin(), 9, out.B);
  std::copy_n(C.begin(), 9, out.C);
  return out;
}

}  // namespace

BodyFigures body_figures(const BodyInertia& body) {
  BodyFigures out;
  out.mass = body.mass;
  std::copy_n(body.com.begin(), 3, out.com);
  const Mat3& I = body.about_com;
  const double entries[6] = {I[0], I[4], I[8], I[1], I[2], I[5]};
  std::copy_n(entries, 6, out.I);
  return out;
}

TreeFigures tree_figures(const RobotTree& tree, const Vec3& gravity) {
  assert(tree.size() <= kMaxJoints);
  TreeFigures out;
  out.n = tree.size();
  std::copy_n(gravity.begin(), 3, out.gravity);
  for (std::size_t j = 0; j < out.n; ++j) {
    const TreeJoint& joint = tree.joints[j];
    if (joint.parent < 0) out.branch_begin[out.branches++] = j;
    out.root[j] = out.branch_begin[out.branches - 1];
    out.joint[j] = joint_figures(joint);
    out.body[j] = body_figures(joint.body);
  }
  out.branch_begin[out.branches] = out.n;
  out.lone_hinge = out.n == 1 && !out.joint[0].prismatic;
  return out;
}

void TreeDynamics::set_positions(const double* q) {
  for (std::size_t b = 0; b < tree_.branches(); ++b) tree_.set_positions(q, b);
}

void TreeDynamics::mass_matrix(JointMatrix& M) const {
  for (std::size_t b = 0; b < tree_.branches(); ++b) tree_.mass_matrix(M.data(), b);
}

void TreeDynamics::bias(const double* dq, JointVector& h) const {
  for (std::size_t b = 0; b < tree_.branches(); ++b) tree_.bias(dq, h.data(), b);
}

void TreeDynamics::inverse_dynamics(const double* dq, const double* ddq, JointVector& tau) const {
  tree_.inverse_dynamics(dq, ddq, tau.data());
}

void TreeDynamics::set_world_force(std::size_t j, const Vec3& force) {
  force_[j] = force;
  tree_.set_force(0, j, force.data());
}

void TreeDynamics::add_world_force(std::size_t j, const Vec3& force) {
  set_world_force(j, force_[j] + force);
}

}  // namespace sanso::diagnose
