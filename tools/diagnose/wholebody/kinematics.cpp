// One pass out from the base; every joint's parent comes before it.
#include "tools/diagnose/wholebody/kinematics.h"

#include <algorithm>
#include <cmath>

#include "shared/math/so3.h"

namespace sanso::diagnose {

V3 turned(const M3& a, const M3& b) {
  const M3 d = a.transpose() * b;
  const double cosine = std::clamp(0.5 * (d.trace() - 1.0), -1.0, 1.0);
  const V3 axis(d(2, 1) - d(1, 2), d(0, 2) - d(2, 0), d(1, 0) - d(0, 1));
  const double sine = 0.5 * axis.norm();
  return sine > 1e-12 ? V3(axis / (2.0 * sine) * std::atan2(sine, cosine)) : V3(V3::Zero());
}

BodyKinematics::BodyKinematics(const WholeBody& body) {
  const auto add = [&](const BodyInertia& b, Body made) {
    made.mass = b.mass, made.com = eigen(b.com), made.inertia = eigen(b.about_com);
    mass_ += b.mass;
    bodies_.push_back(made);
  };
  add(body.base, {});
  for (const TreeJoint& j : body.model.tree.joints) {
    Body made;
    made.parent = j.parent, made.prismatic = j.prismatic;
    made.R = eigen(j.R_parent_joint), made.p = eigen(j.p_parent_joint), made.axis = eigen(j.axis);
    add(j.body, made);
  }
  R_.assign(bodies_.size(), M3::Identity());
  p_.assign(bodies_.size(), V3::Zero());
}

void BodyKinematics::set(const M3& R_base, const V3& p_base, const Eigen::VectorXd& q) {
  R_[0] = R_base, p_[0] = p_base;
  for (std::size_t k = 1; k < bodies_.size(); ++k) {
    const Body& b = bodies_[k];
    const std::size_t up = index(b.parent);
    const double angle = q[static_cast<Eigen::Index>(k - 1)];
    const M3 R_joint = R_[up] * b.R;
    p_[k] = p_[up] + R_[up] * b.p;
    R_[k] = R_joint;
    if (b.prismatic)
      p_[k] += R_joint * b.axis * angle;
    else
      R_[k] = R_joint * math::rotation_matrix(math::quat_exp(b.axis * angle));
  }
}

V3 BodyKinematics::com() const {
  V3 sum = V3::Zero();
  for (std::size_t k = 0; k < bodies_.size(); ++k)
    sum += bodies_[k].mass * (p_[k] + R_[k] * bodies_[k].com);
  return sum / mass_;
}

M3 BodyKinematics::inertia() const {
  const V3 c = com();
  M3 sum = M3::Zero();
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const V3 r = p_[k] + R_[k] * bodies_[k].com - c;
    sum += R_[k] * bodies_[k].inertia * R_[k].transpose() +
           bodies_[k].mass * (r.squaredNorm() * M3::Identity() - r * r.transpose());
  }
  return sum;
}

V3 BodyKinematics::spin_to(const BodyKinematics& later) const {
  const V3 c = com();
  V3 sum = V3::Zero();
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const V3 here = p_[k] + R_[k] * bodies_[k].com;
    const V3 there = later.p_[k] + later.R_[k] * bodies_[k].com;
    sum += bodies_[k].mass * (here - c).cross(there - here) +
           R_[k] * bodies_[k].inertia * turned(R_[k], later.R_[k]);
  }
  return sum;
}

}  // namespace sanso::diagnose
