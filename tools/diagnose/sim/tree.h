// Composite bodies from the tips inwards for M, one pass out and one back for the bias; a branch
// can be recomputed alone. Figures in tree_figures.h, the class for one robot in tree_dynamics.h.
#pragma once

#include "tools/diagnose/sim/lane_math.h"
#include "tools/diagnose/sim/tree_figures.h"

namespace sanso::diagnose::SANSO_ISA {

template <class T>
struct V3 {
  T v[3];
  T& operator[](std::size_t i) { return v[i]; }
  const T& operator[](std::size_t i) const { return v[i]; }
};
template <class T>
inline V3<T> lanes_of(const double* a) {
  return {T(a[0]), T(a[1]), T(a[2])};
}
template <class A, class B, class T = decltype(A() * B())>
inline V3<T> cross(const V3<A>& a, const V3<B>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class T>
inline T dot(const V3<T>& a, const V3<T>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class T>
inline V3<T> scaled(T s, const V3<T>& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
template <class T>
inline void add(V3<T>& a, const V3<T>& b) {
  a[0] += b[0];
  a[1] += b[1];
  a[2] += b[2];
}
/// R v, R stored row by row.
template <class T>
inline V3<T> times(const T* R, const V3<T>& v) {
  return {R[0] * v[0] + R[1] * v[1] + R[2] * v[2], R[3] * v[0] + R[4] * v[1] + R[5] * v[2],
          R[6] * v[0] + R[7] * v[1] + R[8] * v[2]};
}
/// Symmetric matrix stored xx yy zz xy xz yz, times a vector.
template <class T>
inline V3<T> symmetric_times(const T* I, const V3<T>& v) {
  return {I[0] * v[0] + I[3] * v[1] + I[4] * v[2], I[3] * v[0] + I[1] * v[1] + I[5] * v[2],
          I[4] * v[0] + I[5] * v[1] + I[2] * v[2]};
}

/// R I R' for symmetric I.
template <class T>
inline void congruent(const T* R, const T* I, T* out) {
  T P[9];  // R I
  for (std::size_t i = 0; i < 3; ++i) {
    const T a = R[3 * i], b = R[3 * i + 1], c = R[3 * i + 2];
    P[3 * i] = a * I[0] + b * I[3] + c * I[4];
    P[3 * i + 1] = a * I[3] + b * I[1] + c * I[5];
    P[3 * i + 2] = a * I[4] + b * I[5] + c * I[2];
  }
  const auto entry = [&](std::size_t i, std::size_t j) {
    return P[3 * i] * R[3 * j] + P[3 * i + 1] * R[3 * j + 1] + P[3 * i + 2] * R[3 * j + 2];
  };
  out[0] = entry(0, 0);
  out[1] = entry(1, 1);
  out[2] = entry(2, 2);
  out[3] = entry(0, 1);
  out[4] = entry(0, 2);
  out[5] = entry(1, 2);
}

/// The equations of motion; entry (i, j) of a matrix at [i * kMaxJoints + j].
template <class T>
class Tree {
 public:
  explicit Tree(const TreeFigures& figures) : f_(figures) {
    for (std::size_t j = 0; j < f_.n; ++j) {
      body_[j].mass = f_.body[j].mass;
      for (std::size_t k = 0; k < 3; ++k) body_[j].com[k] = f_.body[j].com[k];
      for (std::size_t k = 0; k < 6; ++k) body_[j].I[k] = f_.body[j].I[k];
      force_[j] = {T(0.0), T(0.0), T(0.0)};
    }
    settle_bodies();
  }

  /// The body of one lane; settle_bodies() when all are set.
  void set_body(std::size_t lane, std::size_t j, const BodyFigures& body) {
    set(lane, body.mass, body_[j].mass);
    for (std::size_t k = 0; k < 3; ++k) set(lane, body.com[k], body_[j].com[k]);
    for (std::size_t k = 0; k < 6; ++k) set(lane, body.I[k], body_[j].I[k]);
  }
  /// One revolute joint alone: its inertia is constant and gravity's torque is pull_sine_ sin q +
  /// pull_cosine_ cos q.
  void settle_bodies() {
    if (!f_.lone_hinge) return;
    const T zero = 0.0, quarter = 1.57079632679489661923;
    T h[1], M[1] = {zero};  // a branch without joints has no inertia
    set_frames(&quarter, 0, 1);
    newton_euler<false>(&zero, nullptr, h, 0, 1);
    pull_sine_ = h[0];
    set_frames(&zero, 0, 1);
    newton_euler<false>(&zero, nullptr, h, 0, 1);
    pull_cosine_ = h[0];
    composite_bodies(M, 0);
    lone_inertia_ = M[0];
  }

  std::size_t branch_begin(std::size_t b) const { return f_.branch_begin[b]; }
  std::size_t branches() const { return f_.branches; }

  void set_positions(const T* q, std::size_t branch) {
    if (f_.lone_hinge && !any_force_) {
      kernel::sincos(q[0], lone_sine_, lone_cosine_);
      return;
    }
    set_frames(q, branch_begin(branch), branch_begin(branch + 1));
  }
  void mass_matrix(T* M, std::size_t branch) const {
    if (f_.lone_hinge)
      M[0] = lone_inertia_;
    else
      composite_bodies(M, branch);
  }
  void bias(const T* dq, T* h, std::size_t branch) const {
    if (f_.lone_hinge && !any_force_) {
      h[0] = pull_sine_ * lone_sine_ + pull_cosine_ * lone_cosine_;
      return;
    }
    newton_euler<false>(dq, nullptr, h, branch_begin(branch), branch_begin(branch + 1));
  }
  void inverse_dynamics(const T* dq, const T* ddq, T* tau) const {
    if (f_.lone_hinge && !any_force_) {
      bias(dq, tau, 0);
      tau[0] += lone_inertia_ * ddq[0];
      return;
    }
    newton_euler<true>(dq, ddq, tau, 0, f_.n);
  }

  /// A force at the centre of mass of the link behind joint j, base axes, N; stays until changed.
  void set_force(std::size_t lane, std::size_t j, const double* force) {
    for (std::size_t k = 0; k < 3; ++k) set(lane, force[k], force_[j][k]);
    any_force_ = true;
  }
  const V3<T>& origin(std::size_t j) const { return frame_[j].p; }
  const V3<T>& com(std::size_t j) const { return frame_[j].com; }

 private:
  struct Body {
    T mass;
    V3<T> com;
    T I[6];  // about the centre of mass: xx yy zz xy xz yz
  };
  struct Frame {  // of one link, base axes
    T R[9];
    V3<T> p, com;
    V3<T> s_ang, s_lin;  // motion of the joint as a spatial vector about the base origin
  };
  struct Inertia {  // spatial inertia about the base origin, base axes
    T m;
    V3<T> mc;  // first moment
    T I[6];
  };

  static void set(std::size_t lane, double value, T& to) {
    double x[Kind<T>::kLanes];
    store(to, x);
    x[lane] = value;
    load(x, to);
  }

  void set_frames(const T* q, std::size_t begin, std::size_t end) {
    for (std::size_t j = begin; j < end; ++j) {
      place_link(q, j);
      place_inertia(j);
    }
  }

  void place_link(const T* q, std::size_t j) {
    const JointFigures& c = f_.joint[j];
    Frame& f = frame_[j];
    T sine = 0.0, cosine = 1.0;
    if (!c.prismatic) kernel::sincos(q[j], sine, cosine);
    T R[9];
    for (std::size_t k = 0; k < 9; ++k) R[k] = c.A[k] + sine * c.B[k] + cosine * c.C[k];
    V3<T> p = lanes_of<T>(c.p_parent_joint);
    V3<T> axis = lanes_of<T>(c.axis_parent);
    if (c.prismatic) add(p, scaled(q[j], axis));
    if (c.parent >= 0) {
      const Frame& up = frame_[c.parent];
      for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t s = 0; s < 3; ++s) {
          f.R[3 * r + s] =
              up.R[3 * r] * R[s] + up.R[3 * r + 1] * R[3 + s] + up.R[3 * r + 2] * R[6 + s];
        }
      }
      p = times(up.R, p);
      add(p, up.p);
      axis = times(up.R, axis);
    } else {
      for (std::size_t k = 0; k < 9; ++k) f.R[k] = R[k];
    }
    f.p = p;
    f.s_ang = c.prismatic ? V3<T>{T(0.0), T(0.0), T(0.0)} : axis;
    f.s_lin = c.prismatic ? axis : cross(p, axis);
    f.com = times(f.R, body_[j].com);
    add(f.com, p);
  }

  /// About the base origin: the body's own, turned, plus m (c'c 1 - c c').
  void place_inertia(std::size_t j) {
    Inertia& in = inertia_[j];
    const T mass = body_[j].mass;
    const V3<T>& r = frame_[j].com;
    in.m = mass;
    in.mc = scaled(mass, r);
    congruent(frame_[j].R, body_[j].I, in.I);
    in.I[0] += mass * (r[1] * r[1] + r[2] * r[2]);
    in.I[1] += mass * (r[0] * r[0] + r[2] * r[2]);
    in.I[2] += mass * (r[0] * r[0] + r[1] * r[1]);
    in.I[3] -= mass * r[0] * r[1];
    in.I[4] -= mass * r[0] * r[2];
    in.I[5] -= mass * r[1] * r[2];
  }

  /// Composite bodies, from the tips to the base; then M_ij = s_i . (I_j s_j) for every ancestor i
  /// of j.
  void composite_bodies(T* M, std::size_t branch) const {
    const std::size_t begin = branch_begin(branch), end = branch_begin(branch + 1);
    Inertia composite[kMaxJoints];
    for (std::size_t j = begin; j < end; ++j) composite[j] = inertia_[j];
    for (std::size_t j = end; j-- > begin;) {
      const Inertia& in = composite[j];
      const int parent = f_.joint[j].parent;
      if (parent >= 0) {
        Inertia& up = composite[parent];
        up.m += in.m;
        add(up.mc, in.mc);
        for (std::size_t k = 0; k < 6; ++k) up.I[k] += in.I[k];
      }
      const Frame& f = frame_[j];
      V3<T> angular = symmetric_times(in.I, f.s_ang);
      add(angular, cross(in.mc, f.s_lin));
      V3<T> linear = scaled(in.m, f.s_lin);
      add(linear, cross(f.s_ang, in.mc));
      T* row = M + j * kMaxJoints;
      for (std::size_t k = f_.root[j]; k < j; ++k) row[k] = 0.0;  // siblings inside the branch
      for (int i = static_cast<int>(j); i >= 0; i = f_.joint[i].parent)
        row[i] = dot(frame_[i].s_ang, angular) + dot(frame_[i].s_lin, linear);
    }
  }

  struct Motion {  // of one link: velocity, acceleration, what its inertia asks for
    V3<T> w, v, dw, dv, n, f;
  };

  template <bool kWithAcceleration>
  void newton_euler(const T* dq, const T* ddq, T* tau, std::size_t begin, std::size_t end) const {
    Motion motion[kMaxJoints];
    for (std::size_t j = begin; j < end; ++j) {
      const int parent = f_.joint[j].parent;
      Motion& m = motion[j];
      if (parent < 0) {
        m.w = m.v = m.dw = {T(0.0), T(0.0), T(0.0)};
        m.dv = {T(-f_.gravity[0]), T(-f_.gravity[1]), T(-f_.gravity[2])};
      } else {
        const Motion& up = motion[parent];
        m.w = up.w, m.v = up.v, m.dw = up.dw, m.dv = up.dv;
      }
      const Frame& fr = frame_[j];
      const V3<T> s_ang = scaled(dq[j], fr.s_ang), s_lin = scaled(dq[j], fr.s_lin);
      // a = a_parent + v x s dq (+ s ddq); the parent's velocity may stand in the product since s x
      // s = 0
      add(m.dw, cross(m.w, s_ang));
      add(m.dv, cross(m.w, s_lin));
      add(m.dv, cross(m.v, s_ang));
      if constexpr (kWithAcceleration) {
        add(m.dw, scaled(ddq[j], fr.s_ang));
        add(m.dv, scaled(ddq[j], fr.s_lin));
      }
      add(m.w, s_ang);
      add(m.v, s_lin);
      wrench(j, m);
    }
    for (std::size_t j = end; j-- > begin;) {
      tau[j] = dot(frame_[j].s_ang, motion[j].n) + dot(frame_[j].s_lin, motion[j].f);
      const int parent = f_.joint[j].parent;
      if (parent >= 0) {
        add(motion[parent].n, motion[j].n);
        add(motion[parent].f, motion[j].f);
      }
    }
  }

  /// f = I a + v x* I v, and what acts from outside.
  void wrench(std::size_t j, Motion& m) const {
    const Inertia& in = inertia_[j];
    V3<T> angular = symmetric_times(in.I, m.w);
    add(angular, cross(in.mc, m.v));
    V3<T> linear = scaled(in.m, m.v);
    add(linear, cross(m.w, in.mc));
    m.n = symmetric_times(in.I, m.dw);
    add(m.n, cross(in.mc, m.dv));
    add(m.n, cross(m.w, angular));
    add(m.n, cross(m.v, linear));
    m.f = scaled(in.m, m.dv);
    add(m.f, cross(m.dw, in.mc));
    add(m.f, cross(m.w, linear));
    if (!any_force_) return;
    add(m.n, scaled(T(-1.0), cross(frame_[j].com, force_[j])));
    add(m.f, scaled(T(-1.0), force_[j]));
  }

  TreeFigures f_;
  Body body_[kMaxJoints];
  Frame frame_[kMaxJoints];
  Inertia inertia_[kMaxJoints];
  V3<T> force_[kMaxJoints];
  bool any_force_ = false;
  T lone_inertia_ = 0.0, pull_sine_ = 0.0, pull_cosine_ = 0.0;  // kg m^2, N m, N m
  T lone_sine_ = 0.0, lone_cosine_ = 1.0;
};

}  // namespace sanso::diagnose::SANSO_ISA
