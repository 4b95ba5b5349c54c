// Outwards for motion, inwards for forces; everything in base axes.
#include "tools/diagnose/wholebody/floating_tree.h"

#include "shared/math/so3.h"

namespace sanso::diagnose {

FloatingTree::FloatingTree(const WholeBody& body) {
  const auto add = [&](const BodyInertia& b, Link made) {
    made.mass = b.mass, made.com = eigen(b.com), made.inertia = eigen(b.about_com);
    links_.push_back(made);
  };
  add(body.base, {});
  for (const TreeJoint& j : body.model.tree.joints) {
    Link made;
    made.parent = j.parent, made.prismatic = j.prismatic;
    made.R_parent = eigen(j.R_parent_joint), made.p_parent = eigen(j.p_parent_joint);
    made.axis = eigen(j.axis);
    add(j.body, made);
  }
}

void FloatingTree::set(const FloatingMotion& m) {
  Link& base = links_.front();
  base.w = m.w, base.dw = m.dw, base.acc = m.acc;
  for (std::size_t k = 1; k < links_.size(); ++k) {
    Link& link = links_[k];
    const Link& up = links_[index(link.parent)];
    const auto j = static_cast<Eigen::Index>(k - 1);
    const M3 R = up.R * link.R_parent;
    link.direction = R * link.axis;
    V3 off = up.R * link.p_parent;
    link.w = up.w, link.dw = up.dw, link.R = R;
    V3 sliding = V3::Zero();
    if (link.prismatic) {
      off += m.q[j] * link.direction;
      sliding = m.ddq[j] * link.direction + 2.0 * m.dq[j] * up.w.cross(link.direction);
    } else {
      link.R = R * math::rotation_matrix(math::quat_exp(V3(link.axis * m.q[j])));
      link.w += m.dq[j] * link.direction;
      link.dw += m.ddq[j] * link.direction + m.dq[j] * up.w.cross(link.direction);
    }
    link.p = up.p + off;
    link.acc = up.acc + up.dw.cross(off) + up.w.cross(up.w.cross(off)) + sliding;
  }
}

Eigen::VectorXd FloatingTree::of_wrench(int joint, const V3& force, const V3& moment) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(size());
  const V3 at = links_[index(joint)].p;
  out.head<3>() = force, out.segment<3>(3) = moment + at.cross(force);
  for (int j = joint; j >= 0; j = links_[index(j)].parent) {
    const Link& link = links_[index(j)];
    out[6 + j] = link.prismatic ? link.direction.dot(force)
                                : link.direction.dot(moment + (at - link.p).cross(force));
  }
  return out;
}

Eigen::VectorXd FloatingTree::needed() const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(size());
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const Link& link = links_[k];
    const V3 c = link.R * link.com;
    const M3 inertia = link.R * link.inertia * link.R.transpose();
    const V3 acc = link.acc + link.dw.cross(c) + link.w.cross(link.w.cross(c));
    const V3 force = link.mass * acc;
    const V3 moment = inertia * link.dw + link.w.cross(inertia * link.w) + c.cross(force);
    out += of_wrench(static_cast<int>(k) - 1, force, moment);
  }
  return out;
}

Eigen::VectorXd FloatingTree::of_mass(int joint) const {
  return of_wrench(joint, links_[index(joint)].acc, V3::Zero());
}

Eigen::VectorXd FloatingTree::of_moment(int joint, int axis) const {
  const Link& link = links_[index(joint)];
  const V3 c = link.R.col(axis);
  return of_wrench(joint, link.dw.cross(c) + link.w.cross(link.w.cross(c)), c.cross(link.acc));
}

}  // namespace sanso::diagnose
