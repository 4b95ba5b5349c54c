// Where the links of a floating robot are, and its centre of mass, at one instant.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/diagnose/model_folder/whole_body.h"

namespace sanso::diagnose {

using V3 = Eigen::Vector3d;
using M3 = Eigen::Matrix3d;

/// The same numbers as an Eigen vector, and as an Eigen matrix (Mat3 is stored row by row).
inline V3 eigen(const Vec3& v) { return {v[0], v[1], v[2]}; }
inline M3 eigen(const Mat3& m) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.data());
}

/// Rotation vector that turns the axes a into the axes b, in the axes of a; rad.
V3 turned(const M3& a, const M3& b);

class BodyKinematics {
 public:
  explicit BodyKinematics(const WholeBody& body);

  /// Base orientation (base axes into world axes), position, joint positions (by joint of the
  /// tree).
  void set(const M3& R_base, const V3& p_base, const Eigen::VectorXd& q);

  /// Of the link behind a joint, -1: the base. Link axes into world axes; origin in the world, m;
  /// a point given in link axes, in the world.
  const M3& rotation(int joint) const { return R_[index(joint)]; }  // -1: the base
  const V3& origin(int joint) const { return p_[index(joint)]; }
  V3 at(int joint, const V3& p) const { return origin(joint) + rotation(joint) * p; }
  /// Of the whole robot, kg; its centre of mass in the world, m.
  double mass() const { return mass_; }
  V3 com() const;
  /// Rotational inertia of the whole about its centre of mass, world axes.
  M3 inertia() const;
  /// Angular momentum about the centre of mass of going from here to `later`, a moment after: times
  /// the seconds between. World axes.
  V3 spin_to(const BodyKinematics& later) const;

 private:
  static std::size_t index(int joint) { return static_cast<std::size_t>(joint) + 1; }

  struct Body {
    int parent = -1;
    bool prismatic = false;
    M3 R = M3::Identity();  // parent to joint
    V3 p = V3::Zero(), axis = V3::UnitZ();
    double mass = 0.0;
    V3 com = V3::Zero();
    M3 inertia = M3::Zero();
  };
  std::vector<Body> bodies_;  // the base first
  std::vector<M3> R_;
  std::vector<V3> p_;
  double mass_ = 0.0;
};

}  // namespace sanso::diagnose
