// Steps near a nominal one, for derivatives: its set of touching, sticking and sliding rows is
// held, which to first order is exact. Two kinds:
//   neighbour_step  differs in height, velocities and inputs only at the middle of the step. Mass
//                   matrix, Jacobians and contact geometry are the nominal step's; what changes,
//                   bias forces and servo torques, is evaluated in full. A tenth of the cost.
//   held_step       differs in anything. Only the contact solver is replaced, by one step with
//                   the nominal step's factor.
#pragma once

#include "shared/model/kernel/step.h"
#include "shared/model/nominal_step.h"

namespace sanso::model::SANSO_ISA {

/// Copies one lane of an array of packs, of any rank.
inline void copy_lane(double from, int, double& to) { to = from; }
template <int W>
inline void copy_lane(const Pack<W>& from, int lane, double& to) {
  to = from.v[lane];
}
template <class From, class To, int N>
inline void copy_lane(const From (&from)[N], int lane, To (&to)[N]) {
  for (int i = 0; i < N; ++i) copy_lane(from[i], lane, to[i]);
}

/// The solved contact of a step, made linear: fields as in NominalStep.
template <class T>
struct ContactSlope {
  T weight[kNumFeet][kCornersPerFoot][3], slide[kNumFeet][kCornersPerFoot][2];
  T factor[kTwists][kTwists], contact[kTwists][kTwists], contact_by_height[kTwists],
      contact_by_speed[kTwists];
};

/// Impulses of both soles for a change of their rows' targets.
template <class T>
inline void target_slope(const T (&factor)[kTwists][kTwists], const T (&inertia)[kTwists][kTwists],
                         T (&pushed)[kTwists], T (&impulse)[kTwists]) {
  solve12(factor, pushed);
  for (int i = 0; i < kTwists; ++i) {
    impulse[i] = T(0.0);
    for (int k = 0; k < kTwists; ++k) impulse[i] += inertia[i][k] * pushed[k];
  }
}

/// With N as in contact_newton.h:  t = N^-1 A^-1 dt_free,  impulse = A^-1 (t - dt_free). Height
/// moves the targets of the normal rows instead of the free twists.
template <class T>
inline void contact_slope(const StepModel& model, double h, const StepWork<T>& w,
                          const StepScratch<T>& scratch, ContactSlope<T>& out) {
  const double softness = model.contact.regularization / (1.0 + model.contact.regularization);
  T inertia[kTwists][kTwists], unused[kTwists] = {}, pushed[kTwists], turned[kTwists];
  sole_inertia(w.A, w.A_cross, inertia);
  for (int i = 0; i < kTwists; ++i)
    for (int j = 0; j <= i; ++j)
      inertia[i][j] = inertia[j][i] = out.factor[i][j] = out.factor[j][i] = -inertia[i][j];
  for (T& p : pushed) p = T(0.0);
  for (T& p : turned) p = T(0.0);
  for (int l = 0; l < kNumFeet; ++l)
    for (int k = 0; k < kCornersPerFoot; ++k) {
      const FootContact<T>& foot = w.foot[l];
      CornerSet<T> set;
      corner_set(model.friction_forward, model.friction_sideways, softness, foot, k,
                 scratch.lambda[l][0], set);
      add_corner(foot, k, set, 6 * l, out.factor, unused);
      for (int a = 0; a < 3; ++a) out.weight[l][k][a] = set.weight[a];
      for (int a = 0; a < 2; ++a) out.slide[l][k][a] = set.slide[a];
      const T target = foot.cos_slope *
                       select_less(T(0.0), foot.gap[k], T(1.0), T(model.contact.recovery)) *
                       (2.0 / h);
      const T normal = -set.weight[2] * target;
      const T force[3] = {set.slide[0] * normal, set.slide[1] * normal, normal};
      add_wrench(foot.corner[k], force, pushed + 6 * l);
      if (!model.foot.wheels) continue;
      const T further = -set.weight[2] * foot.bend_ahead[k];
      const T by_speed[3] = {set.slide[0] * further, set.slide[1] * further, further};
      add_wrench(foot.corner[k], by_speed, turned + 6 * l);
    }
  factorize12(out.factor);
  target_slope(out.factor, inertia, pushed, out.contact_by_height);
  if (model.foot.wheels) target_slope(out.factor, inertia, turned, out.contact_by_speed);
#pragma GCC unroll 1
  for (int column = 0; column < kTwists; ++column) {
    T t[kTwists];
    for (int i = 0; i < kTwists; ++i) t[i] = inertia[i][column];
    solve12(out.factor, t);
    for (int i = 0; i < kTwists; ++i) {
      T sum = -inertia[i][column];
      for (int k = 0; k < kTwists; ++k) sum += inertia[i][k] * t[k];
      out.contact[i][column] = sum;
    }
  }
}

/// Keeps what the neighbours of one lane need; x: the middle of its step.
template <class T>
inline void keep_nominal(const StepModel& model, const StepWork<T>& w,
                         const StepScratch<T>& scratch, const ContactSlope<T>& contact, const T* x,
                         const T* u, double h, int lane, NominalStep& n) {
  copy_lane(w.R_world_base, lane, n.R_world_base);
  copy_lane(w.w_base, lane, n.w_base);
  copy_lane(w.bias_base, lane, n.bias_on_base);
  copy_lane(w.base, lane, n.base_factor);
  copy_lane(w.base_inverse_d, lane, n.base_inverse_d);
  copy_lane(w.inverse_d, lane, n.leg_inverse_d);
  copy_lane(w.dv_base, lane, n.dv_base);
  copy_lane(w.d_rate, lane, n.d_rate);
  for (int i = 0; i < 3; ++i) {
    n.a_base[i] = 0;
    for (int j = 0; j < 3; ++j) n.a_base[i] -= n.R_world_base[j][i] * model.gravity_world[j];
  }
  copy_lane(x[kXPos + 2], lane, n.height);
  for (int i = 0; i < 3; ++i) copy_lane(x[kXVel + i], lane, n.v_world[i]);
  copy_lane(scratch.lambda, lane, n.lambda);
  copy_lane(contact.weight, lane, n.weight);
  copy_lane(contact.slide, lane, n.slide);
  copy_lane(contact.factor, lane, n.factor);
  copy_lane(contact.contact, lane, n.contact);
  copy_lane(contact.contact_by_height, lane, n.contact_by_height);
  if (model.foot.wheels) copy_lane(contact.contact_by_speed, lane, n.contact_by_speed);
  for (int l = 0; l < kNumFeet; ++l) {
    const Leg<T>& leg = w.leg[l];
    copy_lane(leg.c, lane, n.cosine[l]);
    copy_lane(leg.s, lane, n.sine[l]);
    copy_lane(leg.rate, lane, n.rate[l]);
    copy_lane(leg.M, lane, n.leg_factor[l]);
    copy_lane(leg.F, lane, n.F[l]);
    copy_lane(w.foot[l].X, lane, n.X[l]);
    copy_lane(w.foot[l].G, lane, n.G[l]);
    for (int j = 0; j < kLegJoints; ++j) {
      const int joint = l * kLegJoints + j;
      const ServoTerms<double> terms = servo_terms<double>(
          model.servo[joint], kOp3Joints[joint].sign, u[joint].v[lane] - x[kXJoint + joint].v[lane],
          n.rate[l][j], leg.bias[j].v[lane], h);
      n.rhs_leg[l][j] = terms.rhs;
      n.implicit[l][j] = terms.implicit;
    }
  }
}

/// What changes against the nominal step: joint rates, and the right-hand sides by servos and bias
/// forces.
template <class T>
inline void changed_forces(const StepModel& model, const NominalStep& n, const T* x, const T* u,
                           double h, T (&rate)[kNumFeet][6], T (&rhs_leg)[kNumFeet][6],
                           T (&rhs_base)[6]) {
  LinkMotion<T> base;
  for (int i = 0; i < 3; ++i) {
    base.w[i] = x[kXOmega + i];
    base.alpha[i] = T(0.0);
    base.a[i] = n.a_base[i];
  }
  Wrench<T> f;
  newton_euler(model.body[0], base.w, base.alpha, base.a, f);
  for (int i = 0; i < 3; ++i) {
    rhs_base[i] = h * (n.bias_on_base[i] - f.force[i]);
    rhs_base[3 + i] = h * (n.bias_on_base[3 + i] - f.moment[i]);
  }
#pragma GCC unroll 1
  for (int l = 0; l < kNumFeet; ++l) {
    Leg<T> leg;
    for (int j = 0; j < kLegJoints; ++j) {
      const int joint = l * kLegJoints + j;
      leg.c[j] = n.cosine[l][j];
      leg.s[j] = n.sine[l][j];
      leg.rate[j] = static_cast<double>(kOp3Joints[joint].sign) * x[kXJointRate + joint];
    }
    leg_bias<0>(model.body + 1 + kLegJoints * l, side_of(l), base, leg, leg.bias_on_base);
    for (int i = 0; i < 3; ++i) {
      rhs_base[i] -= h * leg.bias_on_base.force[i];
      rhs_base[3 + i] -= h * leg.bias_on_base.moment[i];
    }
    for (int j = 0; j < kLegJoints; ++j) {
      const int joint = l * kLegJoints + j;
      const ServoTerms<T> terms =
          servo_terms<T>(model.servo[joint], kOp3Joints[joint].sign, u[joint] - x[kXJoint + joint],
                         leg.rate[j], leg.bias[j], h);
      // a servo at its limit changes the diagonal: to first order that is a torque against the
      // velocity change
      rhs_leg[l][j] =
          terms.rhs - n.rhs_leg[l][j] - (terms.implicit - n.implicit[l][j]) * n.d_rate[l][j];
      rate[l][j] = leg.rate[j] - n.rate[l][j];
    }
  }
}

/// Change of the base's velocities, base axes.
template <class T>
inline void changed_base_velocity(const NominalStep& n, const T* x, T (&v)[6]) {
  T world[3];
  for (int i = 0; i < 3; ++i) world[i] = x[kXVel + i] - n.v_world[i];
  for (int i = 0; i < 3; ++i) {
    v[i] = n.R_world_base[0][i] * world[0] + n.R_world_base[1][i] * world[1] +
           n.R_world_base[2][i] * world[2];
    v[3 + i] = x[kXOmega + i] - n.w_base[i];
  }
}

/// x_next of states that share base orientation and joint angles (and the ground below) with the
/// nominal one at the middle of the step.
template <class T>
inline void neighbour_step(const StepModel& model, const NominalStep& n, const T* start, const T* u,
                           double h, T* x_next) {
  T x[kNx];
  drift(start, 0.5 * h, x);
  T d_leg[kNumFeet][6], d_base[6], moved[kNumFeet][6], moved_base[6];
  changed_forces(model, n, x, u, h, moved, d_leg, d_base);
  changed_base_velocity(n, x, moved_base);
  for (int l = 0; l < kNumFeet; ++l) {
    forward6(n.leg_factor[l], d_leg[l]);
    for (int k = 0; k < 6; ++k) {
      const T scaled = n.leg_inverse_d[l][k] * d_leg[l][k];
      for (int i = 0; i < 6; ++i) d_base[i] -= n.F[l][k][i] * scaled;
      // twist of a sole = X' (L' rate + D^-1 F v) + G' (L' v) with v of the base; row k of L' rate
      // needs the rows below, which are still unchanged
      for (int i = k + 1; i < 6; ++i) moved[l][k] += n.leg_factor[l][i][k] * moved[l][i];
      T by_base = n.F[l][k][0] * moved_base[0];
      for (int i = 1; i < 6; ++i) by_base += n.F[l][k][i] * moved_base[i];
      moved[l][k] += n.leg_inverse_d[l][k] * by_base;
    }
  }
  for (int k = 0; k < 6; ++k)
    for (int i = k + 1; i < 6; ++i) moved_base[k] += n.base_factor[i][k] * moved_base[i];
  forward6(n.base_factor, d_base);
  T free_twist[kTwists], impulse[kTwists];
  for (T& t : free_twist) t = T(0.0);
  for (int l = 0; l < kNumFeet; ++l)
    for (int k = 0; k < 6; ++k) {
      const T leg_part = moved[l][k] + n.leg_inverse_d[l][k] * d_leg[l][k];
      const T base_part = moved_base[k] + n.base_inverse_d[k] * d_base[k];
      for (int i = 0; i < 6; ++i)
        free_twist[6 * l + i] += n.X[l][k][i] * leg_part + n.G[l][k][i] * base_part;
    }
  const T raised = x[kXPos + 2] - n.height;
  for (int i = 0; i < kTwists; ++i) {
    impulse[i] = n.contact_by_height[i] * raised;
    for (int k = 0; k < kTwists; ++k) impulse[i] += n.contact[i][k] * free_twist[k];
  }
  if (model.foot.wheels) {  // they will be elsewhere in the bend at the end of the step
    const T faster = x[kXVel] - n.v_world[0];
    for (int i = 0; i < kTwists; ++i) impulse[i] += n.contact_by_speed[i] * faster;
  }
  for (int l = 0; l < kNumFeet; ++l)
    for (int k = 0; k < 6; ++k)
      for (int i = 0; i < 6; ++i) {
        d_leg[l][k] += n.X[l][k][i] * impulse[6 * l + i];
        d_base[k] += n.G[l][k][i] * impulse[6 * l + i];
      }
  for (int k = 0; k < 6; ++k) d_base[k] = n.base_inverse_d[k] * d_base[k];
  backward6(n.base_factor, d_base);
  for (int l = 0; l < kNumFeet; ++l) {
    for (int k = 0; k < 6; ++k) {
      T rest = d_leg[l][k];
      for (int i = 0; i < 6; ++i) rest -= n.F[l][k][i] * d_base[i];
      d_leg[l][k] = n.leg_inverse_d[l][k] * rest;
    }
    backward6(n.leg_factor[l], d_leg[l]);
    for (int k = 0; k < 6; ++k) d_leg[l][k] = d_leg[l][k] + n.d_rate[l][k];
  }
  T R[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) R[i][j] = n.R_world_base[i][j];
  for (int k = 0; k < 6; ++k) d_base[k] = d_base[k] + n.dv_base[k];
  finish(x, h, R, d_base, d_leg, x_next);
}

/// Residuals of a foot's rows for the nominal impulses; the twist contains their effect already.
template <class T>
inline void held_residuals(const StepModel& model, double h, const T (&A)[6][6],
                           const double (&lambda)[kCornersPerFoot][3], const T* twist,
                           FootContact<T>& foot) {
  const double softness = model.contact.regularization;
  for (int k = 0; k < kCornersPerFoot; ++k) {
    T* s = foot.residual + 3 * k;
    corner_velocity(twist, foot.corner[k], s);
    s[0] += (softness * lambda[k][0]) * row_diagonal<0>(A, foot.corner[k]);
    s[1] += (softness * lambda[k][1]) * row_diagonal<1>(A, foot.corner[k]);
    s[2] += (softness * lambda[k][2]) * row_diagonal<2>(A, foot.corner[k]) +
            normal_target(model, h, foot, k);
  }
}

/// foot.impulse from the nominal impulses and their first-order change, the set of rows held.
template <class T>
inline void held_contact(const StepModel& model, const NominalStep& n, double h, StepWork<T>& w) {
  T tau[kTwists];
  for (int l = 0; l < kNumFeet; ++l) {
    FootContact<T>& foot = w.foot[l];
    for (T& f : foot.impulse) f = T(0.0);
    for (int k = 0; k < kCornersPerFoot; ++k) {
      const T lambda[3] = {T(n.lambda[l][k][0]), T(n.lambda[l][k][1]), T(n.lambda[l][k][2])};
      add_wrench(foot.corner[k], lambda, foot.impulse);
    }
  }
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k < 6; ++k) {
      w.foot[0].twist[i] +=
          w.A[0][i][k] * w.foot[0].impulse[k] + w.A_cross[i][k] * w.foot[1].impulse[k];
      w.foot[1].twist[i] +=
          w.A[1][i][k] * w.foot[1].impulse[k] + w.A_cross[k][i] * w.foot[0].impulse[k];
    }
  const auto push = [&](int l, int k, T normal, T forward, T across, T* wrench) {
    const T force[3] = {forward + n.slide[l][k][0] * normal, across + n.slide[l][k][1] * normal,
                        normal};
    add_wrench(w.foot[l].corner[k], force, wrench);
  };
  for (int l = 0; l < kNumFeet; ++l) {
    FootContact<T>& foot = w.foot[l];
    held_residuals(model, h, w.A[l], n.lambda[l], foot.twist, foot);
    for (int i = 0; i < 6; ++i) tau[6 * l + i] = T(0.0);
    for (int k = 0; k < kCornersPerFoot; ++k) {
      const T* s = foot.residual + 3 * k;
      const double* weight = n.weight[l][k];
      push(l, k, -weight[2] * s[2], -weight[0] * s[0], -weight[1] * s[1], tau + 6 * l);
    }
  }
  solve12(n.factor, tau);
  for (int l = 0; l < kNumFeet; ++l)
    for (int k = 0; k < kCornersPerFoot; ++k) {
      FootContact<T>& foot = w.foot[l];
      T u[3];
      corner_velocity(tau + 6 * l, foot.corner[k], u);
      for (int a = 0; a < 3; ++a) u[a] = -n.weight[l][k][a] * (foot.residual[3 * k + a] + u[a]);
      push(l, k, u[2], u[0], u[1], foot.impulse);
    }
}

/// x_next of any state nearby.
template <class T>
inline void held_step(const StepModel& model, const Ground& ground, const NominalStep& n,
                      const T* x, const T* u, double h, T* x_next) {
  StepWork<T> w;
  T middle[kNx];
  drift(x, 0.5 * h, middle);
  free_step(model, ground, middle, u, h, w);
  held_contact(model, n, h, w);
  velocity_change(w, w.dv_base, w.d_rate);
  finish(middle, h, w.R_world_base, w.dv_base, w.d_rate, x_next);
}

}  // namespace sanso::model::SANSO_ISA
