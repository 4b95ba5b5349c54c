// Kinematics, recursive Newton-Euler and composite bodies, all of it in world axes.
#include "tests/oracle/tree.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace sanso::model {
namespace {

// Entries of the scratch: 0 is the base, joint i moves entry i + 1.
int entry_of(int link) { return link + 1; }

Vec3 com_in_world(const TreeKinematics& kin, int entry, const LinkInertia& link) {
  return kin.p_world_link[entry] + kin.R_world_link[entry] * link.com;
}
Mat3 inertia_in_world(const TreeKinematics& kin, int entry, const LinkInertia& link) {
  return kin.R_world_link[entry] * link.about_com * kin.R_world_link[entry].transpose();
}

// Force and moment about the link's origin that the motion of the link asks for, gravity taken off.
void newton_euler(const Tree& tree, const LinkInertia& link, int e, TreeScratch& s) {
  const Vec3 c = s.kin.R_world_link[e] * link.com;
  const Vec3 dv_com = s.dv[e] + s.dw[e].cross(c) + s.w[e].cross(s.w[e].cross(c));
  const Mat3 I = inertia_in_world(s.kin, e, link);
  s.force[e] = link.mass * (dv_com - tree.gravity);
  s.moment[e] = I * s.dw[e] + s.w[e].cross(I * s.w[e]) + c.cross(s.force[e]);
}

void base_motion(const Tree& tree, const TreeVector& v, const TreeVector& dv, TreeScratch& s) {
  s.w[0] = s.v[0] = s.dw[0] = s.dv[0] = Vec3::Zero();
  if (!tree.floating) return;
  const Mat3& R_world_base = s.kin.R_world_link[0];
  s.v[0] = v.segment<3>(0);
  s.w[0] = R_world_base * v.segment<3>(3);
  s.dv[0] = dv.segment<3>(0);
  s.dw[0] = R_world_base * dv.segment<3>(3);  // d/dt (R w) = R dw, because w x w = 0
}

// Adds a body to the composite body of entry e.
void absorb(TreeScratch& s, int e, double mass, const Vec3& com, const Mat3& inertia) {
  const double total = s.mass[e] + mass;
  if (total <= 0.0) {
    s.inertia[e] += inertia;
    return;
  }
  const Vec3 joint_com = (s.mass[e] * s.com[e] + mass * com) / total;
  const auto shifted = [&joint_com](double m, const Vec3& c) {
    const Vec3 d = c - joint_com;
    return Mat3(m * (d.squaredNorm() * Mat3::Identity() - d * d.transpose()));
  };
  s.inertia[e] += shifted(s.mass[e], s.com[e]) + inertia + shifted(mass, com);
  s.mass[e] = total;
  s.com[e] = joint_com;
}

void composite_bodies(const Tree& tree, TreeScratch& s) {
  const int n = tree.num_joints();
  for (int e = 0; e <= n; ++e) {
    const LinkInertia& link = e == 0 ? tree.base : tree.joints[e - 1].link;
    s.mass[e] = link.mass;
    s.com[e] = com_in_world(s.kin, e, link);
    s.inertia[e] = inertia_in_world(s.kin, e, link);
  }
  for (int i = n - 1; i >= 0; --i) {
    const int e = entry_of(i);
    absorb(s, entry_of(tree.joints[i].parent), s.mass[e], s.com[e], s.inertia[e]);
  }
}

// Momentum of the composite body of entry e when the world moves it with (w, v at `origin`).
struct Momentum {
  Vec3 linear, angular;  // angular about `origin`
};
Momentum composite_momentum(const TreeScratch& s, int e, const Vec3& origin, const Vec3& w,
                            const Vec3& v) {
  const Vec3 c = s.com[e] - origin;
  const Vec3 linear = s.mass[e] * (v + w.cross(c));
  return {linear, s.inertia[e] * w + c.cross(linear)};
}

// Component of a momentum (given about `origin`) along the motion of joint i.
double along_joint(const Tree& tree, const TreeKinematics& kin, int i, const Momentum& h,
                   const Vec3& origin) {
  const Vec3& axis = kin.axis_world[entry_of(i)];
  if (tree.joints[i].kind == JointKind::prismatic) return axis.dot(h.linear);
  return axis.dot(h.angular + (origin - kin.p_world_link[entry_of(i)]).cross(h.linear));
}

void base_rows(const Tree& tree, const TreeKinematics& kin, const Momentum& h, const Vec3& origin,
               int column, TreeMatrix& M) {
  if (!tree.floating) return;
  const Vec3 about_base = h.angular + (origin - kin.p_world_link[0]).cross(h.linear);
  M.block<3, 1>(0, column) = h.linear;
  M.block<3, 1>(3, column) = kin.R_world_link[0].transpose() * about_base;
}

}  // namespace

LinkInertia combined(const LinkInertia& a, const LinkInertia& b) {
  const double mass = a.mass + b.mass;
  if (mass <= 0.0) return {0.0, Vec3::Zero(), a.about_com + b.about_com};
  const Vec3 com = (a.mass * a.com + b.mass * b.com) / mass;
  const auto shifted = [&com](const LinkInertia& l) {
    const Vec3 d = l.com - com;
    return Mat3(l.about_com + l.mass * (d.squaredNorm() * Mat3::Identity() - d * d.transpose()));
  };
  return {mass, com, shifted(a) + shifted(b)};
}

void forward_kinematics(const Tree& tree, const TreeVector& q, TreeKinematics& out) {
  out.R_world_link[0] =
      tree.floating ? math::rotation_matrix(q.segment<4>(3)) : Mat3(Mat3::Identity());
  out.p_world_link[0] = tree.floating ? Vec3(q.segment<3>(0)) : Vec3(Vec3::Zero());
  out.axis_world[0] = Vec3::Zero();
  const int first = tree.floating ? 7 : 0;
  for (int i = 0; i < tree.num_joints(); ++i) {
    const TreeJoint& joint = tree.joints[i];
    const int e = entry_of(i), parent = entry_of(joint.parent);
    const Mat3 R_world_link0 = out.R_world_link[parent] * joint.R_parent_link0;
    out.p_world_link[e] =
        out.p_world_link[parent] + out.R_world_link[parent] * joint.p_parent_link0;
    out.axis_world[e] = R_world_link0 * joint.axis;
    out.R_world_link[e] = R_world_link0;
    if (joint.kind == JointKind::revolute) {
      out.R_world_link[e] =
          R_world_link0 * math::rotation_matrix(math::quat_exp(q[first + i] * joint.axis));
    } else {
      out.p_world_link[e] += q[first + i] * out.axis_world[e];
    }
  }
}

void rnea(const Tree& tree, const TreeVector& q, const TreeVector& v, const TreeVector& dv,
          TreeScratch& s, TreeVector& tau) {
  forward_kinematics(tree, q, s.kin);
  base_motion(tree, v, dv, s);
  const int n = tree.num_joints(), first = tree.first_joint_v();
  newton_euler(tree, tree.base, 0, s);

  // outwards: velocity and acceleration of every link's origin
  for (int i = 0; i < n; ++i) {
    const TreeJoint& joint = tree.joints[i];
    const int e = entry_of(i), p = entry_of(joint.parent);
    const Vec3 r = s.kin.p_world_link[e] - s.kin.p_world_link[p];
    const Vec3& axis = s.kin.axis_world[e];
    const double rate = v[first + i], acceleration = dv[first + i];
    s.w[e] = s.w[p];
    s.dw[e] = s.dw[p];
    s.v[e] = s.v[p] + s.w[p].cross(r);
    s.dv[e] = s.dv[p] + s.dw[p].cross(r) + s.w[p].cross(s.w[p].cross(r));
    if (joint.kind == JointKind::revolute) {
      s.w[e] += rate * axis;
      s.dw[e] += acceleration * axis + s.w[p].cross(rate * axis);
    } else {
      s.v[e] += rate * axis;
      s.dv[e] += acceleration * axis + 2.0 * s.w[p].cross(rate * axis);  // Coriolis
    }
    newton_euler(tree, joint.link, e, s);
  }

  // inwards: what each joint has to transmit
  tau.resize(tree.nv());
  for (int i = n - 1; i >= 0; --i) {
    const TreeJoint& joint = tree.joints[i];
    const int e = entry_of(i), p = entry_of(joint.parent);
    const Vec3& axis = s.kin.axis_world[e];
    tau[first + i] = axis.dot(joint.kind == JointKind::revolute ? s.moment[e] : s.force[e]) +
                     joint.armature * dv[first + i];
    s.moment[p] += s.moment[e] + (s.kin.p_world_link[e] - s.kin.p_world_link[p]).cross(s.force[e]);
    s.force[p] += s.force[e];
  }
  if (tree.floating) {
    tau.segment<3>(0) = s.force[0];
    tau.segment<3>(3) = s.kin.R_world_link[0].transpose() * s.moment[0];
  }
}

void crba(const Tree& tree, const TreeVector& q, TreeScratch& s, TreeMatrix& M) {
  forward_kinematics(tree, q, s.kin);
  composite_bodies(tree, s);
  const int n = tree.num_joints(), first = tree.first_joint_v();
  M.setZero(tree.nv(), tree.nv());

  // column of joint j: momentum of everything behind it per unit rate, seen by each joint on the
  // way to the base
  for (int j = 0; j < n; ++j) {
    const int e = entry_of(j);
    const Vec3& origin = s.kin.p_world_link[e];
    const bool turns = tree.joints[j].kind == JointKind::revolute;
    const Vec3 w = turns ? s.kin.axis_world[e] : Vec3(Vec3::Zero()),
               v = turns ? Vec3(Vec3::Zero()) : s.kin.axis_world[e];
    const Momentum h = composite_momentum(s, e, origin, w, v);
    for (int i = j; i >= 0; i = tree.joints[i].parent) {
      M(first + i, first + j) = M(first + j, first + i) = along_joint(tree, s.kin, i, h, origin);
    }
    M(first + j, first + j) += tree.joints[j].armature;
    base_rows(tree, s.kin, h, origin, first + j, M);
  }
  if (!tree.floating) return;
  for (int k = 0; k < 3; ++k) {
    const Vec3& origin = s.kin.p_world_link[0];
    base_rows(tree, s.kin, composite_momentum(s, 0, origin, Vec3::Zero(), Vec3::Unit(k)), origin, k,
              M);
    base_rows(tree, s.kin,
              composite_momentum(s, 0, origin, s.kin.R_world_link[0].col(k), Vec3::Zero()), origin,
              3 + k, M);
  }
  M.bottomLeftCorner(n, 6) = M.topRightCorner(6, n).transpose();
}

Status forward_dynamics(const Tree& tree, const TreeVector& q, const TreeVector& v,
                        const TreeVector& tau, TreeScratch& s, TreeVector& dv) {
  dv.setZero(tree.nv());
  rnea(tree, q, v, dv, s, s.bias);
  crba(tree, q, s, s.M);
  const Eigen::LLT<TreeMatrix> factor(s.M);
  if (factor.info() != Eigen::Success) return Status::not_ready;
  dv = tau - s.bias;
  factor.solveInPlace(dv);
  return Status::ok;
}

void point_jacobian(const Tree& tree, const TreeKinematics& kin, int link, const Vec3& p_link_point,
                    TreeJacobian& linear, TreeJacobian& angular) {
  linear.setZero(3, tree.nv());
  angular.setZero(3, tree.nv());
  const Vec3 p_world_point =
      kin.p_world_link[entry_of(link)] + kin.R_world_link[entry_of(link)] * p_link_point;
  const int first = tree.first_joint_v();
  for (int i = link; i >= 0; i = tree.joints[i].parent) {
    const Vec3& axis = kin.axis_world[entry_of(i)];
    if (tree.joints[i].kind == JointKind::revolute) {
      angular.col(first + i) = axis;
      linear.col(first + i) = axis.cross(p_world_point - kin.p_world_link[entry_of(i)]);
    } else {
      linear.col(first + i) = axis;
    }
  }
  if (!tree.floating) return;
  linear.block<3, 3>(0, 0).setIdentity();
  angular.block<3, 3>(0, 3) = kin.R_world_link[0];
  linear.block<3, 3>(0, 3) = -math::skew(p_world_point - kin.p_world_link[0]) * kin.R_world_link[0];
}

TreeEnergy energy(const Tree& tree, const TreeVector& q, const TreeVector& v, TreeScratch& s) {
  crba(tree, q, s, s.M);
  TreeEnergy e;
  e.kinetic = 0.5 * v.dot(s.M * v);
  for (int i = tree.floating ? -1 : 0; i < tree.num_joints(); ++i) {
    const LinkInertia& link = i < 0 ? tree.base : tree.joints[i].link;
    e.potential -= link.mass * tree.gravity.dot(com_in_world(s.kin, entry_of(i), link));
  }
  return e;
}

TreeVector integrate(const Tree& tree, const TreeVector& q, const TreeVector& v, double dt) {
  TreeVector next = q;
  const int n = tree.num_joints();
  if (tree.floating) {
    next.segment<3>(0) += dt * v.segment<3>(0);
    next.segment<4>(3) = math::quat_plus(q.segment<4>(3), dt * v.segment<3>(3));
  }
  next.tail(n) += dt * v.tail(n);
  return next;
}

}  // namespace sanso::model
