// Newton's and Euler's equations of a robot whose base floats, read backwards: the forces that a
// motion needs, and what of them each figure of a link makes. Linear in masses and first moments.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/diagnose/wholebody/kinematics.h"

namespace sanso::diagnose {

/// Motion at one instant. The acceleration is that which an accelerometer feels (less gravity), so
/// nobody has to know the vertical.
struct FloatingMotion {
  V3 acc = V3::Zero(), w = V3::Zero(), dw = V3::Zero();  // of the base's origin, base axes
  Eigen::VectorXd q, dq, ddq;
};

class FloatingTree {
 public:
  explicit FloatingTree(const WholeBody& body);

  /// Numbers of a generalised force: on the base (force, then moment about its origin, base axes)
  /// and about every joint.
  int size() const { return 6 + static_cast<int>(links_.size()) - 1; }
  void set(const FloatingMotion& motion);

  /// Axes of a joint's link in base axes.
  const M3& rotation(int joint) const { return links_[index(joint)].R; }

  /// What the motion needs, nothing touching: N, N m.
  Eigen::VectorXd needed() const;
  /// Of a kilogram at the origin of a joint's link (-1: the base), and of a first moment of 1 kg m
  /// along an axis of that link.
  Eigen::VectorXd of_mass(int joint) const;
  Eigen::VectorXd of_moment(int joint, int axis) const;
  /// What a force and a moment at the origin of a joint's link do, base axes.
  Eigen::VectorXd of_wrench(int joint, const V3& force, const V3& moment) const;

 private:
  static std::size_t index(int joint) { return static_cast<std::size_t>(joint) + 1; }
  struct Link {
    int parent = -1;
    bool prismatic = false;
    M3 R_parent = M3::Identity();
    V3 p_parent = V3::Zero(), axis = V3::UnitZ();
    double mass = 0.0;
    V3 com = V3::Zero();
    M3 inertia = M3::Zero();  // about the centre of mass
    // of this instant, base axes
    M3 R = M3::Identity();
    V3 p = V3::Zero(), direction = V3::UnitZ();
    V3 w = V3::Zero(), dw = V3::Zero(), acc = V3::Zero();
  };
  std::vector<Link> links_;  // the base first
};

}  // namespace sanso::diagnose
