// Steps near a nominal one that differ from it in joint rates and inputs only. Mass matrix, Jacobians and contact
// geometry are the nominal step's, and its set of touching, sticking and sliding rows is held: to first order the exact
// step, at a tenth of its cost. What changes, bias forces and servo torques, is evaluated in full.
#pragma once

#include "shared/model/kernel/step.h"
#include "shared/model/nominal_step.h"

namespace sanso::model::SANSO_ISA {

/// Copies one lane of an array of packs, of any rank.
template <int W>
inline void copy_lane(const Pack<W>& from, int lane, double& to) {
  to = from.v[lane];
}
template <class From, class To, int N>
inline void copy_lane(const From (&from)[N], int lane, To (&to)[N]) {
  for (int i = 0; i < N; ++i) copy_lane(from[i], lane, to[i]);
}

/// n.contact: impulse change of both soles per change of their free twists, with the set of rows held.
///   t = N^-1 A^-1 dt_free,  impulse = A^-1 (t - dt_free),  N as in contact_newton.h
template <class T>
inline void contact_response(const StepModel& model, const double (&A)[kNumFeet][6][6], const double (&A_cross)[6][6],
                             const FootContact<double> (&foot)[kNumFeet],
                             const double (&lambda)[kNumFeet][kCornersPerFoot][3], NominalStep& n) {
  constexpr int kLanesOf = sizeof(T) / sizeof(double);
  const double softness = model.contact.regularization / (1.0 + model.contact.regularization);
  double inertia[kTwists][kTwists], M[kTwists][kTwists], unused[kTwists] = {};
  sole_inertia(A, A_cross, inertia);
  for (int i = 0; i < kTwists; ++i)
    for (int j = 0; j <= i; ++j) inertia[i][j] = inertia[j][i] = M[i][j] = M[j][i] = -inertia[i][j];
  for (int l = 0; l < kNumFeet; ++l)
    for (int k = 0; k < kCornersPerFoot; ++k) {
      CornerSet<double> set;
      corner_set(model.friction_forward, model.friction_sideways, softness, foot[l], k, lambda[l][0], set);
      add_corner(foot[l], k, set, 6 * l, M, unused);
    }
  factorize12(M);
  for (int first = 0; first < kTwists; first += kLanesOf) {  // columns in lanes
    T pushed[kTwists], t[kTwists];
    for (int i = 0; i < kTwists; ++i) {
      pushed[i] = T(0.0);
      for (int lane = 0; lane < kLanesOf && first + lane < kTwists; ++lane)
        pushed[i].v[lane] = inertia[i][first + lane];
      t[i] = pushed[i];
    }
    solve12(M, t);
    for (int i = 0; i < kTwists; ++i) {
      T sum = -pushed[i];
      for (int k = 0; k < kTwists; ++k) sum += inertia[i][k] * t[k];
      for (int lane = 0; lane < kLanesOf; ++lane) n.contact[i][first + lane] = sum.v[lane];
    }
  }
}

/// Keeps what the neighbours of one lane need.
template <class T>
inline void keep_nominal(const StepModel& model, const StepWork<T>& w, const StepScratch<T>& scratch, const T* x,
                         const T* u, double h, int lane, NominalStep& n) {
  copy_lane(w.R_world_base, lane, n.R_world_base);
  copy_lane(w.w_base, lane, n.w_base);
  copy_lane(w.base, lane, n.base_factor);
  copy_lane(w.base_inverse_d, lane, n.base_inverse_d);
  copy_lane(w.inverse_d, lane, n.leg_inverse_d);
  copy_lane(w.dv_base, lane, n.dv_base);
  copy_lane(w.d_rate, lane, n.d_rate);
  for (int i = 0; i < 3; ++i) {
    n.a_base[i] = 0;
    for (int j = 0; j < 3; ++j) n.a_base[i] -= n.R_world_base[j][i] * model.gravity_world[j];
  }
  double A[kNumFeet][6][6], A_cross[6][6], lambda[kNumFeet][kCornersPerFoot][3];
  FootContact<double> foot[kNumFeet];
  copy_lane(w.A, lane, A);
  copy_lane(w.A_cross, lane, A_cross);
  copy_lane(scratch.lambda, lane, lambda);
  for (double& f : n.bias_on_base) f = 0;
  for (int l = 0; l < kNumFeet; ++l) {
    const Leg<T>& leg = w.leg[l];
    copy_lane(leg.c, lane, n.cosine[l]);
    copy_lane(leg.s, lane, n.sine[l]);
    copy_lane(leg.rate, lane, n.rate[l]);
    copy_lane(leg.M, lane, n.leg_factor[l]);
    copy_lane(leg.F, lane, n.F[l]);
    copy_lane(w.foot[l].X, lane, n.X[l]);
    copy_lane(w.foot[l].G, lane, n.G[l]);
    copy_lane(w.foot[l].corner, lane, foot[l].corner);
    copy_lane(w.foot[l].residual, lane, foot[l].residual);
    copy_lane(w.foot[l].inverse_diagonal, lane, foot[l].inverse_diagonal);
    for (int i = 0; i < 3; ++i) {
      n.bias_on_base[i] += leg.bias_on_base.force[i].v[lane];
      n.bias_on_base[3 + i] += leg.bias_on_base.moment[i].v[lane];
    }
    for (int j = 0; j < kLegJoints; ++j) {
      const int joint = l * kLegJoints + j;
      const ServoTerms<double> terms =
          servo_terms<double>(model.servo[joint], kOp3Joints[joint].sign, u[joint].v[lane] - x[kXJoint + joint].v[lane],
                              n.rate[l][j], leg.bias[j].v[lane], h);
      n.rhs_leg[l][j] = terms.rhs;
      n.implicit[l][j] = terms.implicit;
    }
  }
  contact_response<T>(model, A, A_cross, foot, lambda, n);
}

/// Changes of the right-hand sides against the nominal step: servos and bias forces of both legs.
template <class T>
inline void changed_forces(const StepModel& model, const NominalStep& n, const T* x, const T* u, double h,
                           T (&rate)[kNumFeet][6], T (&rhs_leg)[kNumFeet][6], T (&rhs_base)[6]) {
  LinkMotion<T> base;
  for (int i = 0; i < 3; ++i) {
    base.w[i] = n.w_base[i];
    base.alpha[i] = T(0.0);
    base.a[i] = n.a_base[i];
  }
  for (int i = 0; i < 6; ++i) rhs_base[i] = h * n.bias_on_base[i];
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
      const ServoTerms<T> terms = servo_terms<T>(model.servo[joint], kOp3Joints[joint].sign,
                                                 u[joint] - x[kXJoint + joint], leg.rate[j], leg.bias[j], h);
      // a servo at its limit changes the diagonal: to first order that is a torque against the velocity change
      rhs_leg[l][j] = terms.rhs - n.rhs_leg[l][j] - (terms.implicit - n.implicit[l][j]) * n.d_rate[l][j];
      rate[l][j] = leg.rate[j] - n.rate[l][j];
    }
  }
}

/// x_next of states that share base and joint angles with the nominal one.
template <class T>
inline void neighbour_step(const StepModel& model, const NominalStep& n, const T* x, const T* u, double h, T* x_next) {
  T d_leg[kNumFeet][6], d_base[6], moved[kNumFeet][6];
  changed_forces(model, n, x, u, h, moved, d_leg, d_base);
  for (int l = 0; l < kNumFeet; ++l) {
    forward6(n.leg_factor[l], d_leg[l]);
    for (int k = 0; k < 6; ++k) {
      const T scaled = n.leg_inverse_d[l][k] * d_leg[l][k];
      for (int i = 0; i < 6; ++i) d_base[i] -= n.F[l][k][i] * scaled;
      // J rate = X' (L' rate): row k of L' rate needs the rows below, which are still unchanged
      for (int i = k + 1; i < 6; ++i) moved[l][k] += n.leg_factor[l][i][k] * moved[l][i];
    }
  }
  forward6(n.base_factor, d_base);
  T free_twist[kTwists], impulse[kTwists];
  for (T& t : free_twist) t = T(0.0);
  for (int l = 0; l < kNumFeet; ++l)
    for (int k = 0; k < 6; ++k) {
      const T leg_part = moved[l][k] + n.leg_inverse_d[l][k] * d_leg[l][k], base_part = n.base_inverse_d[k] * d_base[k];
      for (int i = 0; i < 6; ++i) free_twist[6 * l + i] += n.X[l][k][i] * leg_part + n.G[l][k][i] * base_part;
    }
  for (int i = 0; i < kTwists; ++i) {
    impulse[i] = T(0.0);
    for (int k = 0; k < kTwists; ++k) impulse[i] += n.contact[i][k] * free_twist[k];
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
  integrate(x, h, R, d_base, d_leg, x_next);
}

}  // namespace sanso::model::SANSO_ISA
