// Writes a Tree as MuJoCo's XML, so that MuJoCo serves as a second witness. Link i is body
// "link<i>", the base "base".
#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <sstream>
#include <string>

#include "tests/oracle/tree.h"

namespace sanso::testing {

inline std::string text(const Eigen::Ref<const Eigen::VectorXd>& v) {
  std::ostringstream out;
  out.precision(17);
  for (Eigen::Index i = 0; i < v.size(); ++i) out << (i ? " " : "") << v[i];
  return out.str();
}

inline std::string quaternion_text(const model::Mat3& R) {
  const Eigen::Quaterniond q(R);
  return text(Eigen::Vector4d(q.w(), q.x(), q.y(), q.z()));
}

// Principal moments and axes are computed here: MuJoCo's own diagonalisation stops at 1e-12 kg m^2,
// a relative error of 1e-9 for bodies as small as these.
inline std::string inertial(const model::LinkInertia& l) {
  const Eigen::SelfAdjointEigenSolver<model::Mat3> principal(l.about_com);
  model::Mat3 axes = principal.eigenvectors();
  if (axes.determinant() < 0) axes.col(2) *= -1.0;
  return "<inertial mass=\"" + text(Eigen::Matrix<double, 1, 1>(l.mass)) + "\" pos=\"" +
         text(l.com) + "\" quat=\"" + quaternion_text(axes) + "\" diaginertia=\"" +
         text(principal.eigenvalues()) + "\"/>";
}

inline std::string children_of(const model::Tree& tree, int parent) {
  std::string xml;
  for (int i = 0; i < tree.num_joints(); ++i) {
    const model::TreeJoint& j = tree.joints[i];
    if (j.parent != parent) continue;
    const std::string name = std::to_string(i);
    xml += "<body name=\"link" + name + "\" pos=\"" + text(j.p_parent_link0) + "\" quat=\"" +
           quaternion_text(j.R_parent_link0) + "\">" + inertial(j.link) + "<joint name=\"joint" +
           name + "\" type=\"" + (j.kind == model::JointKind::revolute ? "hinge" : "slide") +
           "\" axis=\"" + text(j.axis) + "\" armature=\"" +
           text(Eigen::Matrix<double, 1, 1>(j.armature)) + "\"/>" + children_of(tree, i) +
           "</body>";
  }
  return xml;
}

/// MuJoCo numbers its joints depth first: give trees whose joints are in that order.
inline std::string mjcf_of(const model::Tree& tree) {
  const std::string head =
      "<mujoco><compiler angle=\"radian\" balanceinertia=\"false\" boundmass=\"0\" "
      "boundinertia=\"0\"/>"
      "<option gravity=\"" +
      text(tree.gravity) + "\"/><worldbody>";
  const std::string tail = "</worldbody></mujoco>";
  if (!tree.floating) return head + children_of(tree, -1) + tail;
  return head + "<body name=\"base\">" + inertial(tree.base) + "<freejoint/>" +
         children_of(tree, -1) + "</body>" + tail;
}

}  // namespace sanso::testing
