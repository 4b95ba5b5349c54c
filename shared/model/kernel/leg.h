// One leg of the OP3 in link axes: inverse dynamics at zero acceleration (bias) and the mass matrix
// of the chain.
// All axes are coordinate axes and no joint has a fixed rotation, so every turn costs four
// products. Both legs have the same axes and mirrored origins. Angles here turn about the positive
// coordinate axis; the sign of the joint is applied where the state is read and where the result is
// written.
#pragma once

#include "shared/model/kernel/trig.h"
#include "shared/model/step_model.h"

namespace sanso::model::SANSO_ISA {

inline constexpr int kLegJoints = 6;

// Figures of the left leg; the right leg mirrors y.
constexpr const JointGeometry& leg_joint(int j) { return kOp3Joints[kLegJoints + j]; }
constexpr int axis_of(int j) { return leg_joint(j).axis; }
constexpr bool legs_mirror() {
  for (int j = 0; j < kLegJoints; ++j) {
    const JointGeometry &r = kOp3Joints[j], &l = kOp3Joints[kLegJoints + j];
    if (r.axis != l.axis || r.origin[0] != l.origin[0] || r.origin[1] != -l.origin[1] ||
        r.origin[2] != l.origin[2])
      return false;
  }
  return true;
}
static_assert(legs_mirror(), "the kernel uses one geometry for both legs");

/// Components of v after the child axes turned by (c, s) about axis K: parent to child.
template <int K, class T>
inline void to_child(T c, T s, const T* v, T* out) {
  constexpr int I = (K + 1) % 3, J = (K + 2) % 3;
  const T vi = v[I], vj = v[J];
  out[K] = v[K];
  out[I] = c * vi + s * vj;
  out[J] = c * vj - s * vi;
}
template <int K, class T>
inline void to_parent(T c, T s, const T* v, T* out) {
  constexpr int I = (K + 1) % 3, J = (K + 2) % 3;
  const T vi = v[I], vj = v[J];
  out[K] = v[K];
  out[I] = c * vi - s * vj;
  out[J] = c * vj + s * vi;
}

/// out += r x v with r the origin of leg joint J in parent axes; zero components of r cost nothing.
template <int J, class T>
inline void add_origin_cross(double side, const T* v, T* out) {
  constexpr double rx = leg_joint(J).origin[0], ry = leg_joint(J).origin[1],
                   rz = leg_joint(J).origin[2];
  if constexpr (rx != 0.0) {
    out[1] -= rx * v[2];
    out[2] += rx * v[1];
  }
  if constexpr (ry != 0.0) {
    out[0] += (side * ry) * v[2];
    out[2] -= (side * ry) * v[0];
  }
  if constexpr (rz != 0.0) {
    out[0] -= rz * v[1];
    out[1] += rz * v[0];
  }
}

/// out = a x b; `out` is neither of them.
template <class T>
inline void cross(const T* a, const T* b, T* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}
template <class T>
inline T dot(const T* a, const T* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// out = I v for a symmetric I (xx xy xz yy yz zz), entries of type S (double or T).
template <class S, class T>
inline void inertia_times(const S* I, const T* v, T* out) {
  out[0] = I[0] * v[0] + I[1] * v[1] + I[2] * v[2];
  out[1] = I[1] * v[0] + I[3] * v[1] + I[4] * v[2];
  out[2] = I[2] * v[0] + I[4] * v[1] + I[5] * v[2];
}
// index into xx xy xz yy yz zz
constexpr int sym(int i, int j) { return i <= j ? (i * (5 - i)) / 2 + j : sym(j, i); }

template <class T>
struct Wrench {
  T force[3];   // N
  T moment[3];  // N m, about the origin of the frame it is written in
};

/// Net force and moment (about the link origin) that move a body with angular velocity w, angular
/// acceleration alpha and
/// acceleration a of its origin (gravity already subtracted).   [Newton-Euler about a body-fixed
/// point]
template <class T>
inline void newton_euler(const StepModel::Body& b, const T* w, const T* alpha, const T* a,
                         Wrench<T>& f) {
  T h[3], wh[3], wwh[3], ah[3], Iw[3], wIw[3], Ialpha[3], ha[3];
  for (int i = 0; i < 3; ++i) h[i] = b.first_moment[i];
  cross(w, h, wh);
  cross(w, wh, wwh);
  cross(alpha, h, ah);
  for (int i = 0; i < 3; ++i) f.force[i] = b.mass * a[i] + ah[i] + wwh[i];
  inertia_times(b.inertia, w, Iw);
  cross(w, Iw, wIw);
  inertia_times(b.inertia, alpha, Ialpha);
  cross(h, a, ha);
  for (int i = 0; i < 3; ++i) f.moment[i] = Ialpha[i] + wIw[i] + ha[i];
}

/// Composite body: first moment and inertia about the origin of the frame it is written in; its
/// mass is a constant.
template <class T>
struct Composite {
  T h[3];
  T I[6];
};

/// Work space and results of one leg.
template <class T>
struct Leg {
  T c[kLegJoints], s[kLegJoints];  // cosine and sine of the turn about the positive axis
  T rate[kLegJoints];              // rad/s about the positive axis
  T bias[kLegJoints];              // N m, joint torques at zero acceleration
  Wrench<T> bias_on_base;          // the leg's share, base axes
  T M[kLegJoints][kLegJoints];     // joint block of the mass matrix (lower triangle)
  T F[kLegJoints][6];              // coupling with the base: force, moment in base axes
  Composite<T> composite;          // of the whole leg, base axes and origin
};

/// Of a link in its own axes: rate [rad/s], its derivative, acceleration of the origin [m/s^2].
template <class T>
struct LinkMotion {
  T w[3], alpha[3], a[3];
};

/// Motion of the link behind joint J from that of its parent. `side`: +1 left, -1 right.
template <int J, class T>
inline void link_motion(const Leg<T>& leg, double side, const LinkMotion<T>& parent,
                        LinkMotion<T>& child) {
  constexpr int K = axis_of(J), I1 = (K + 1) % 3, I2 = (K + 2) % 3;
  // origin of the joint: a + alpha x r + w x (w x r), in parent axes; x cross r = -(r cross x)
  T minus_wr[3] = {0.0, 0.0, 0.0}, minus_alpha_r[3] = {0.0, 0.0, 0.0}, wwr[3], a[3];
  add_origin_cross<J>(side, parent.w, minus_wr);
  add_origin_cross<J>(side, parent.alpha, minus_alpha_r);
  cross(minus_wr, parent.w, wwr);
  for (int i = 0; i < 3; ++i) a[i] = parent.a[i] - minus_alpha_r[i] + wwr[i];
  to_child<K>(leg.c[J], leg.s[J], a, child.a);
  to_child<K>(leg.c[J], leg.s[J], parent.w, child.w);
  to_child<K>(leg.c[J], leg.s[J], parent.alpha, child.alpha);
  // w x (axis rate), with w still that of the parent in child axes; its own part along the axis
  // adds nothing
  child.alpha[I1] += child.w[I2] * leg.rate[J];
  child.alpha[I2] -= child.w[I1] * leg.rate[J];
  child.w[K] += leg.rate[J];
}

/// Force and moment [N, N m] of the link behind joint J, in axes and about the origin of its
/// parent.
template <int J, class T>
inline void wrench_to_parent(const Leg<T>& leg, double side, const Wrench<T>& child,
                             Wrench<T>& out) {
  constexpr int K = axis_of(J);
  to_parent<K>(leg.c[J], leg.s[J], child.force, out.force);
  to_parent<K>(leg.c[J], leg.s[J], child.moment, out.moment);
  add_origin_cross<J>(side, out.force, out.moment);
}

/// Forward pass to the foot, backward pass to the base (recursive Newton-Euler, [Featherstone 2008]
/// table 5.1).
template <int J, class T>
inline void leg_bias(const StepModel::Body* bodies, double side, const LinkMotion<T>& parent,
                     Leg<T>& leg, Wrench<T>& on_parent) {
  LinkMotion<T> m;
  link_motion<J>(leg, side, parent, m);
  Wrench<T> f;
  newton_euler(bodies[J], m.w, m.alpha, m.a, f);
  if constexpr (J + 1 < kLegJoints) {
    Wrench<T> carried;
    leg_bias<J + 1>(bodies, side, m, leg, carried);
    for (int i = 0; i < 3; ++i) {
      f.force[i] += carried.force[i];
      f.moment[i] += carried.moment[i];
    }
  }
  leg.bias[J] = f.moment[axis_of(J)];
  wrench_to_parent<J>(leg, side, f, on_parent);
}

/// Rewrites a composite body from child axes and origin to those of the parent of joint J.
template <int J, class T>
inline void composite_to_parent(const Leg<T>& leg, double side, double mass, const Composite<T>& in,
                                Composite<T>& out) {
  constexpr int K = axis_of(J), A = (K + 1) % 3, B = (K + 2) % 3;
  const T c = leg.c[J], s = leg.s[J];
  to_parent<K>(c, s, in.h, out.h);
  // R I R' for a turn about axis K
  const T t = c * in.I[sym(A, A)] - s * in.I[sym(A, B)];
  const T u = c * in.I[sym(A, B)] - s * in.I[sym(B, B)];
  out.I[sym(K, K)] = in.I[sym(K, K)];
  out.I[sym(A, A)] = c * t - s * u;
  out.I[sym(A, B)] = s * t + c * u;
  out.I[sym(B, B)] = in.I[sym(A, A)] + in.I[sym(B, B)] - out.I[sym(A, A)];
  out.I[sym(K, A)] = c * in.I[sym(K, A)] - s * in.I[sym(K, B)];
  out.I[sym(K, B)] = s * in.I[sym(K, A)] + c * in.I[sym(K, B)];
  // parallel axes: with d = h + m r / 2,  I += 2 r.d E - r d' - d r',  h += m r
  constexpr double rx = leg_joint(J).origin[0], ry_left = leg_joint(J).origin[1],
                   rz = leg_joint(J).origin[2];
  const double ry = side * ry_left;
  T d[3];
  d[0] = out.h[0] + 0.5 * mass * rx;
  d[1] = out.h[1] + 0.5 * mass * ry;
  d[2] = out.h[2] + 0.5 * mass * rz;
  if constexpr (rx != 0.0) {
    const T xx = (2.0 * rx) * d[0];
    out.I[3] += xx;
    out.I[5] += xx;
    out.I[1] -= rx * d[1];
    out.I[2] -= rx * d[2];
    out.h[0] += T(mass * rx);
  }
  if constexpr (ry_left != 0.0) {
    const T yy = (2.0 * ry) * d[1];
    out.I[0] += yy;
    out.I[5] += yy;
    out.I[1] -= ry * d[0];
    out.I[4] -= ry * d[2];
    out.h[1] += T(mass * ry);
  }
  if constexpr (rz != 0.0) {
    const T zz = (2.0 * rz) * d[2];
    out.I[0] += zz;
    out.I[3] += zz;
    out.I[2] -= rz * d[0];
    out.I[4] -= rz * d[1];
    out.h[2] += T(mass * rz);
  }
}

/// Carries the wrench of a unit acceleration of joint J from link I down to the base, reading off
/// column entries.
template <int J, int I, class T>
inline void mass_column(Leg<T>& leg, double side, const Wrench<T>& f) {
  leg.M[J][I] = f.moment[axis_of(I)];
  Wrench<T> up;
  wrench_to_parent<I>(leg, side, f, up);
  if constexpr (I > 0) {
    mass_column<J, I - 1>(leg, side, up);
  } else {
    for (int i = 0; i < 3; ++i) {
      leg.F[J][i] = up.force[i];
      leg.F[J][3 + i] = up.moment[i];
    }
  }
}

/// Composite rigid bodies from the foot upwards ([Featherstone 2008] table 6.2). Result `out`:
/// links J..5 as seen by the parent of joint J.
template <int J, class T>
inline void leg_mass_matrix(const StepModel::Body* bodies, double side, Leg<T>& leg,
                            Composite<T>& out) {
  constexpr int K = axis_of(J), A = (K + 1) % 3, B = (K + 2) % 3;
  Composite<T> here;
  if constexpr (J + 1 < kLegJoints) {
    leg_mass_matrix<J + 1>(bodies, side, leg, here);
    for (int i = 0; i < 3; ++i) here.h[i] += T(bodies[J].first_moment[i]);
    for (int i = 0; i < 6; ++i) here.I[i] += T(bodies[J].inertia[i]);
  } else {
    for (int i = 0; i < 3; ++i) here.h[i] = bodies[J].first_moment[i];
    for (int i = 0; i < 6; ++i) here.I[i] = bodies[J].inertia[i];
  }
  // unit acceleration about the axis: moment = I e_K, force = e_K x h
  Wrench<T> f;
  for (int i = 0; i < 3; ++i) f.moment[i] = here.I[sym(K, i)];
  f.force[K] = T(0.0);
  f.force[A] = -here.h[B];
  f.force[B] = here.h[A];
  mass_column<J, J>(leg, side, f);
  composite_to_parent<J>(leg, side, bodies[J].subtree_mass, here, out);
}

/// Axes and origins of the leg's joints in base axes, down to the foot.
template <class T>
struct LegFrames {
  T axis[kLegJoints][3];    // unit vectors about which the (unsigned) joint angle turns
  T origin[kLegJoints][3];  // m, from the base origin
  T R_base_foot[3][3];      // [column][component]: foot axes in base axes
};

/// Fills axis and origin of joint J and those below. R: columns of the parent's axes in base axes
/// when called, of the foot's when it returns.
template <int J, class T>
inline void leg_frames(const Leg<T>& leg, double side, T (&R)[3][3], LegFrames<T>& out) {
  constexpr int K = axis_of(J), A = (K + 1) % 3, B = (K + 2) % 3;
  constexpr double rx = leg_joint(J).origin[0], ry_left = leg_joint(J).origin[1],
                   rz = leg_joint(J).origin[2];
  for (int i = 0; i < 3; ++i) {
    T p = J > 0 ? out.origin[J > 0 ? J - 1 : 0][i] : T(0.0);
    if constexpr (rx != 0.0) p += rx * R[0][i];
    if constexpr (ry_left != 0.0) p += (side * ry_left) * R[1][i];
    if constexpr (rz != 0.0) p += rz * R[2][i];
    out.origin[J][i] = p;
    out.axis[J][i] = R[K][i];
    const T a = R[A][i], b = R[B][i];
    R[A][i] = leg.c[J] * a + leg.s[J] * b;
    R[B][i] = leg.c[J] * b - leg.s[J] * a;
  }
  if constexpr (J + 1 < kLegJoints) {
    leg_frames<J + 1>(leg, side, R, out);
  } else {
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) out.R_base_foot[k][i] = R[k][i];
  }
}

}  // namespace sanso::model::SANSO_ISA
