// Composite bodies from the tips inwards for M, one pass out and one back for the bias; a branch
// can be recomputed alone.
#include "tools/diagnose/sim/tree_dynamics.h"

#include <cassert>
#include <cmath>
#include <numbers>

namespace sanso::diagnose {
namespace {

inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Vec3 scaled(double s, const Vec3& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline void add(Vec3& a, const Vec3& b) { a[0] += b[0], a[1] += b[1], a[2] += b[2]; }
inline Vec3 times(const std::array<double, 9>& R, const Vec3& v) {
  return {R[0] * v[0] + R[1] * v[1] + R[2] * v[2], R[3] * v[0] + R[4] * v[1] + R[5] * v[2],
          R[6] * v[0] + R[7] * v[1] + R[8] * v[2]};
}
/// Symmetric matrix stored xx yy zz xy xz yz, times a vector.
inline Vec3 symmetric_times(const std::array<double, 6>& I, const Vec3& v) {
  return {I[0] * v[0] + I[3] * v[1] + I[4] * v[2], I[3] * v[0] + I[1] * v[1] + I[5] * v[2],
          I[4] * v[0] + I[5] * v[1] + I[2] * v[2]};
}

/// R I R' for symmetric I.
inline std::array<double, 6> congruent(const std::array<double, 9>& R,
                                       const std::array<double, 6>& I) {
  double T[9];  // R I
  for (int i = 0; i < 3; ++i) {
    const double a = R[3 * i], b = R[3 * i + 1], c = R[3 * i + 2];
    T[3 * i] = a * I[0] + b * I[3] + c * I[4];
    T[3 * i + 1] = a * I[3] + b * I[1] + c * I[5];
    T[3 * i + 2] = a * I[4] + b * I[5] + c * I[2];
  }
  const auto entry = [&](int i, int j) {
    return T[3 * i] * R[3 * j] + T[3 * i + 1] * R[3 * j + 1] + T[3 * i + 2] * R[3 * j + 2];
  };
  return {entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)};
}

}  // namespace

TreeDynamics::TreeDynamics(const RobotTree& tree, const Vec3& gravity)
    : n_(tree.size()), gravity_(gravity) {
  assert(n_ <= kMaxJoints);
  for (int j = 0; j < n_; ++j) {
    const TreeJoint& joint = tree.joints[static_cast<std::size_t>(j)];
    Constant& c = constant_[static_cast<std::size_t>(j)];
    if (joint.parent < 0) branch_begin_.push_back(j);
    root_[static_cast<std::size_t>(j)] = branch_begin_.back();
    c.parent = joint.parent;
    c.prismatic = joint.prismatic;
    c.p_parent_joint = joint.p_parent_joint;
    c.axis_joint = joint.axis;
    c.axis_parent = rotated(joint.R_parent_joint, joint.axis);
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
    c.A = product(joint.R_parent_joint, outer);
    c.B = product(joint.R_parent_joint, skew);
    c.C = product(joint.R_parent_joint, rest);
    c.mass = joint.body.mass;
    c.com = joint.body.com;
    const Mat3& I = joint.body.about_com;
    c.I = {I[0], I[4], I[8], I[1], I[2], I[5]};
  }
  branch_begin_.push_back(n_);
  if (n_ != 1 || constant_[0].prismatic) return;
  const double zero = 0.0, quarter = std::numbers::pi / 2;
  JointVector h{};
  JointMatrix M{};
  set_frames(&quarter, 0, 1);
  recursive_newton_euler<false>(&zero, nullptr, h, 0, 1);
  pull_sine_ = h[0];
  set_frames(&zero, 0, 1);
  recursive_newton_euler<false>(&zero, nullptr, h, 0, 1);
  pull_cosine_ = h[0];
  mass_matrix(M);
  lone_inertia_ = M[0];
  lone_hinge_ = true;
}

void TreeDynamics::set_positions(const double* q) {
  for (int b = 0; b < branches(); ++b) set_positions(q, b);
}

void TreeDynamics::set_positions(const double* q, int branch) {
  if (lone_hinge_ && !any_force_) {
    lone_q_ = q[0];
    return;
  }
  set_frames(q, branch_begin(branch), branch_begin(branch + 1));
}

void TreeDynamics::set_frames(const double* q, int begin, int end) {
  for (int j = begin; j < end; ++j) {
    const Constant& c = constant_[static_cast<std::size_t>(j)];
    Frame& f = frame_[static_cast<std::size_t>(j)];
    const double sine = c.prismatic ? 0.0 : std::sin(q[j]);
    const double cosine = c.prismatic ? 1.0 : std::cos(q[j]);
    std::array<double, 9> R;
    for (std::size_t k = 0; k < 9; ++k) R[k] = c.A[k] + sine * c.B[k] + cosine * c.C[k];
    Vec3 p = c.p_parent_joint;
    Vec3 axis = c.axis_parent;
    if (c.prismatic) add(p, scaled(q[j], c.axis_parent));
    if (c.parent >= 0) {
      const Frame& up = frame_[static_cast<std::size_t>(c.parent)];
      std::array<double, 9> R_base;
      for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t s = 0; s < 3; ++s) {
          R_base[3 * r + s] =
              up.R[3 * r] * R[s] + up.R[3 * r + 1] * R[3 + s] + up.R[3 * r + 2] * R[6 + s];
        }
      }
      R = R_base;
      p = times(up.R, p);
      add(p, up.p);
      axis = times(up.R, axis);
    }
    f.R = R;
    f.p = p;
    f.s_ang = c.prismatic ? Vec3{0, 0, 0} : axis;
    f.s_lin = c.prismatic ? axis : cross(p, axis);
    f.com = times(R, c.com);
    add(f.com, p);

    // inertia about the base origin: the body's own, turned, plus m (c'c 1 - c c')
    Inertia& in = inertia_[static_cast<std::size_t>(j)];
    const Vec3& r = f.com;
    in.m = c.mass;
    in.mc = scaled(c.mass, r);
    in.I = congruent(R, c.I);
    in.I[0] += c.mass * (r[1] * r[1] + r[2] * r[2]);
    in.I[1] += c.mass * (r[0] * r[0] + r[2] * r[2]);
    in.I[2] += c.mass * (r[0] * r[0] + r[1] * r[1]);
    in.I[3] -= c.mass * r[0] * r[1];
    in.I[4] -= c.mass * r[0] * r[2];
    in.I[5] -= c.mass * r[1] * r[2];
  }
}

void TreeDynamics::mass_matrix(JointMatrix& M) const {
  for (int b = 0; b < branches(); ++b) mass_matrix(M, b);
}

void TreeDynamics::mass_matrix(JointMatrix& M, int branch) const {
  if (lone_hinge_) {
    M[0] = lone_inertia_;
    return;
  }
  // composite bodies, from the tips to the base; then M_ij = s_i . (I_j s_j) for every ancestor i
  // of j
  const int begin = branch_begin(branch), end = branch_begin(branch + 1);
  std::array<Inertia, kMaxJoints> composite;
  for (int j = begin; j < end; ++j)
    composite[static_cast<std::size_t>(j)] = inertia_[static_cast<std::size_t>(j)];
  for (int j = end - 1; j >= begin; --j) {
    const Inertia& in = composite[static_cast<std::size_t>(j)];
    const int parent = constant_[static_cast<std::size_t>(j)].parent;
    if (parent >= 0) {
      Inertia& up = composite[static_cast<std::size_t>(parent)];
      up.m += in.m;
      add(up.mc, in.mc);
      for (std::size_t k = 0; k < 6; ++k) up.I[k] += in.I[k];
    }
    const Frame& f = frame_[static_cast<std::size_t>(j)];
    Vec3 angular = symmetric_times(in.I, f.s_ang);
    add(angular, cross(in.mc, f.s_lin));
    Vec3 linear = scaled(in.m, f.s_lin);
    add(linear, cross(f.s_ang, in.mc));
    double* row = &M[static_cast<std::size_t>(j) * kMaxJoints];
    // siblings inside the branch
    for (int k = root_[static_cast<std::size_t>(j)]; k < j; ++k) row[k] = 0.0;
    for (int i = j; i >= 0; i = constant_[static_cast<std::size_t>(i)].parent) {
      const Frame& g = frame_[static_cast<std::size_t>(i)];
      row[i] = dot(g.s_ang, angular) + dot(g.s_lin, linear);
    }
  }
}

template <bool kWithAcceleration>
void TreeDynamics::recursive_newton_euler(const double* dq, const double* ddq, JointVector& tau,
                                          int begin, int end) const {
  std::array<Vec3, kMaxJoints> w, v, dw, dv, n, f;
  for (int j = begin; j < end; ++j) {
    const auto k = static_cast<std::size_t>(j);
    const Constant& c = constant_[k];
    const Frame& fr = frame_[k];
    if (c.parent < 0) {
      w[k] = v[k] = dw[k] = {0, 0, 0};
      dv[k] = {-gravity_[0], -gravity_[1], -gravity_[2]};
    } else {
      const auto up = static_cast<std::size_t>(c.parent);
      w[k] = w[up], v[k] = v[up], dw[k] = dw[up], dv[k] = dv[up];
    }
    const Vec3 s_ang = scaled(dq[j], fr.s_ang), s_lin = scaled(dq[j], fr.s_lin);
    // a = a_parent + v x s dq (+ s ddq); the parent's velocity may stand in the product since s x s
    // = 0
    add(dw[k], cross(w[k], s_ang));
    add(dv[k], cross(w[k], s_lin));
    add(dv[k], cross(v[k], s_ang));
    if constexpr (kWithAcceleration) {
      add(dw[k], scaled(ddq[j], fr.s_ang));
      add(dv[k], scaled(ddq[j], fr.s_lin));
    }
    add(w[k], s_ang);
    add(v[k], s_lin);
    // f = I a + v x* I v
    const Inertia& in = inertia_[k];
    Vec3 angular = symmetric_times(in.I, w[k]);
    add(angular, cross(in.mc, v[k]));
    Vec3 linear = scaled(in.m, v[k]);
    add(linear, cross(w[k], in.mc));
    n[k] = symmetric_times(in.I, dw[k]);
    add(n[k], cross(in.mc, dv[k]));
    add(n[k], cross(w[k], angular));
    add(n[k], cross(v[k], linear));
    f[k] = scaled(in.m, dv[k]);
    add(f[k], cross(dw[k], in.mc));
    add(f[k], cross(w[k], linear));
    if (any_force_) {
      const Vec3& F = force_[k];
      const Vec3 moment = cross(fr.com, F);
      add(n[k], scaled(-1.0, moment));
      add(f[k], scaled(-1.0, F));
    }
  }
  for (int j = end - 1; j >= begin; --j) {
    const auto k = static_cast<std::size_t>(j);
    tau[k] = dot(frame_[k].s_ang, n[k]) + dot(frame_[k].s_lin, f[k]);
    if (constant_[k].parent >= 0) {
      const auto up = static_cast<std::size_t>(constant_[k].parent);
      add(n[up], n[k]);
      add(f[up], f[k]);
    }
  }
}

void TreeDynamics::bias(const double* dq, JointVector& h) const {
  for (int b = 0; b < branches(); ++b) bias(dq, h, b);
}

void TreeDynamics::bias(const double* dq, JointVector& h, int branch) const {
  if (lone_hinge_ && !any_force_) {
    h[0] = pull_sine_ * std::sin(lone_q_) + pull_cosine_ * std::cos(lone_q_);
    return;
  }
  recursive_newton_euler<false>(dq, nullptr, h, branch_begin(branch), branch_begin(branch + 1));
}

void TreeDynamics::inverse_dynamics(const double* dq, const double* ddq, JointVector& tau) const {
  if (lone_hinge_ && !any_force_) {
    bias(dq, tau);
    tau[0] += lone_inertia_ * ddq[0];
    return;
  }
  recursive_newton_euler<true>(dq, ddq, tau, 0, n_);
}

}  // namespace sanso::diagnose
