// One implicit step of the whole body: x' = f_A(x, u, theta), by Moreau's midpoint rule (Moreau
// 1988, "Unilateral contact and dry friction in finite freedom dynamics"). Written for one double
// and for lanes alike.
//   q_M = q + h/2 v
//   (M + armature + h/2 D + h^2/4 K) (v' - v) = h (K (u - q_M) - D v - bias) + J' lambda   at q_M
//   q'  = q_M + h/2 v'
// Everything is taken at the middle of the step, and the servo's spring and damping with the means
// of both ends: second order where contact does not change. Implicit, or 60 ms would explode;
// contact works on the same effective inertia. Base velocities are in base axes inside (orientation
// frozen at the middle of the step).
#pragma once

#include "shared/model/kernel/step_work.h"

namespace sanso::model::SANSO_ISA {

/// Mass matrix and bias forces of both legs and the base.
template <class T>
inline void rigid_body(const StepModel& model, StepWork<T>& w) {
  // Galilean invariance: the base's own velocity does not enter. Gravity as an acceleration of the
  // base upwards.
  LinkMotion<T> base;
  for (int i = 0; i < 3; ++i) {
    base.w[i] = w.w_base[i];
    base.alpha[i] = T(0.0);
    base.a[i] = -(w.R_world_base[0][i] * model.gravity_world[0] +
                  w.R_world_base[1][i] * model.gravity_world[1] +
                  w.R_world_base[2][i] * model.gravity_world[2]);
  }
  Wrench<T> f;
  newton_euler(model.body[0], base.w, base.alpha, base.a, f);
  T h[3], I[6];
  for (int i = 0; i < 3; ++i) h[i] = model.body[0].first_moment[i];
  for (int i = 0; i < 6; ++i) I[i] = model.body[0].inertia[i];
#pragma GCC unroll 1
  for (int l = 0; l < kNumFeet; ++l) {
    Leg<T>& leg = w.leg[l];
    const StepModel::Body* bodies = model.body + 1 + kLegJoints * l;
    leg_bias<0>(bodies, side_of(l), base, leg, leg.bias_on_base);
    leg_mass_matrix<0>(bodies, side_of(l), leg, leg.composite);
    for (int i = 0; i < 3; ++i) {
      f.force[i] += leg.bias_on_base.force[i];
      f.moment[i] += leg.bias_on_base.moment[i];
      h[i] += leg.composite.h[i];
    }
    for (int i = 0; i < 6; ++i) I[i] += leg.composite.I[i];
  }
  for (int i = 0; i < 3; ++i) {
    w.bias_base[i] = f.force[i];
    w.bias_base[3 + i] = f.moment[i];
    for (int j = 0; j < 3; ++j) {
      w.base[i][j] = T(i == j ? model.body[0].subtree_mass : 0.0);
      w.base[3 + i][3 + j] = I[sym(i, j)];
    }
  }
  w.base[3][0] = w.base[4][1] = w.base[5][2] = T(0.0);
  w.base[3][1] = -h[2];
  w.base[3][2] = h[1];
  w.base[4][0] = h[2];
  w.base[4][2] = -h[0];
  w.base[5][0] = -h[1];
  w.base[5][1] = h[0];
}

/// Adds the implicit servo to the diagonal and writes the right-hand sides of the velocity change.
/// Full duty is a secant stiffness, K min(1, limit / |K e|): continuous in the error, and with the
/// back-EMF in the damping it is the motor's torque-speed line. Dry friction likewise is a secant
/// damping, coulomb / max(|rate|, 0.05 rad/s), of the velocity at the end alone: as strong as it
/// may be, the mean would let a joint ring.
template <class T>
struct ServoTerms {
  T implicit;  // kg m^2, h/2 D + h^2/4 K: adds to the diagonal
  T rhs;       // N m s
};
/// `sign`: of the joint's axis; error [rad] at the middle of the step and rate [rad/s] at its
/// beginning as the servo has them; `bias` [N m]: what the motion asks of the joint; step h [s].
template <class T>
inline ServoTerms<T> servo_terms(const ServoParameters& p, double sign, T error, T rate, T bias,
                                 double h) {
  constexpr double kFrictionRate = 0.05;  // rad/s, about two steps of the servo's velocity register
  const T limited = p.torque_limit / max_of(abs_of(p.stiffness * error), T(p.torque_limit));
  const T stiffness = p.stiffness * limited;
  const T friction = p.coulomb / max_of(abs_of(rate), T(kFrictionRate));
  return {h * (0.5 * p.damping + friction) + (0.25 * h * h) * stiffness,
          h * (sign * stiffness * error - bias - (p.damping + friction) * rate)};
}

/// For all joints: adds to the legs' mass matrices, writes rhs_leg and rhs_base. x: the middle.
template <class T>
inline void servo(const StepModel& model, const T* x, const T* u, double h, StepWork<T>& w) {
  for (int l = 0; l < kNumFeet; ++l)
    for (int j = 0; j < kLegJoints; ++j) {
      const int joint = l * kLegJoints + j;
      const ServoParameters& p = model.servo[joint];
      const T error = u[joint] - x[kXJoint + joint];
      const ServoTerms<T> terms =
          servo_terms<T>(p, kOp3Joints[joint].sign, error, w.leg[l].rate[j], w.leg[l].bias[j], h);
      w.rhs_leg[l][j] = terms.rhs;
      w.leg[l].M[j][j] += terms.implicit + p.armature;
    }
  for (int i = 0; i < 6; ++i) w.rhs_base[i] = -h * w.bias_base[i];
}

/// Eliminates the legs, factorizes the base, and forms the inverse inertias of the soles.
template <class T>
inline void factorize(StepWork<T>& w) {
  for (int l = 0; l < kNumFeet; ++l) {
    Leg<T>& leg = w.leg[l];
    FootContact<T>& foot = w.foot[l];
    factorize6(leg.M, w.inverse_d[l]);
    forward6<6>(leg.M, leg.F);
    forward6<6>(leg.M, foot.X);
    forward6(leg.M, w.rhs_leg[l]);
    subtract_product<true>(leg.F, w.inverse_d[l], leg.F, w.base);
    subtract_product<false>(leg.F, w.inverse_d[l], foot.X, foot.G);
    for (int k = 0; k < 6; ++k) {
      const T scaled = w.inverse_d[l][k] * w.rhs_leg[l][k];
      for (int i = 0; i < 6; ++i) w.rhs_base[i] -= leg.F[k][i] * scaled;
    }
  }
  factorize6(w.base, w.base_inverse_d);
  forward6(w.base, w.rhs_base);
  for (int l = 0; l < kNumFeet; ++l) forward6<6>(w.base, w.foot[l].G);
}

/// Inverse inertia of each sole and of the pair, and the soles' twists after the step without
/// contact.
template <class T>
inline void sole_response(StepWork<T>& w) {
  for (int l = 0; l < kNumFeet; ++l) {
    FootContact<T>& foot = w.foot[l];
    weighted_squares(foot.X, w.inverse_d[l], foot.G, w.base_inverse_d, w.A[l]);
    for (int k = 0; k < 6; ++k) {
      const T leg_part = w.inverse_d[l][k] * w.rhs_leg[l][k],
              base_part = w.base_inverse_d[k] * w.rhs_base[k];
      for (int i = 0; i < 6; ++i)
        foot.twist[i] += foot.X[k][i] * leg_part + foot.G[k][i] * base_part;
    }
  }
  for (auto& row : w.A_cross)
    for (T& entry : row) entry = T(0.0);
  add_weighted_product(w.foot[0].G, w.base_inverse_d, w.foot[1].G, w.A_cross);
}

/// twist of the other foot += A_cross (or its transpose) x impulse.
template <bool FromLeft, class T>
inline void couple(const T (&A_cross)[6][6], const T* impulse, T* twist) {
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k < 6; ++k) twist[i] += (FromLeft ? A_cross[i][k] : A_cross[k][i]) * impulse[k];
}

/// m/s, of a corner's normal row: with the velocity u' at the end of the step the gap closes where
/// u' + target = 0, in the half step that is left; of a penetration a share only (`recovery`).
/// Wheels roll on with u' to the middle of the next step, and the ground bends away below them.
template <class T>
inline T normal_target(const StepModel& model, double h, const FootContact<T>& foot, int k) {
  const T gap = max_of(foot.gap[k], model.contact.recovery * foot.gap[k]) * (2.0 / h);
  return model.foot.wheels ? gap + foot.bend[k] * (1.0 / h) : gap;
}

/// Residuals of all rows for the twists without contact and the impulses in `lambda`.
template <class T>
inline void start_contact(const StepModel& model, double h, StepWork<T>& w,
                          StepScratch<T>& scratch) {
  for (int l = 0; l < kNumFeet; ++l) {
    FootContact<T>& foot = w.foot[l];
    row_diagonals(w.A[l], model.contact.regularization, foot);
    for (T& f : foot.impulse) f = T(0.0);
    for (int k = 0; k < kCornersPerFoot; ++k) {
      scratch.gap[l][k] = foot.gap[k];
      foot.residual[3 * k] = foot.residual[3 * k + 1] = T(0.0);
      foot.residual[3 * k + 2] = normal_target(model, h, foot, k);
      if (scratch.warm_start) {
        add_wrench(foot.corner[k], scratch.lambda[l][k], foot.impulse);
      } else {
        for (T& component : scratch.lambda[l][k]) component = T(0.0);
      }
    }
  }
  if (scratch.warm_start) {
    const double softness = model.contact.regularization / (1.0 + model.contact.regularization);
    for (int l = 0; l < kNumFeet; ++l) {
      FootContact<T>& foot = w.foot[l];
      for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 6; ++k) foot.twist[i] += w.A[l][i][k] * foot.impulse[k];
      for (int i = 0; i < kFootRows; ++i)
        foot.residual[i] += softness * foot.diagonal[i] * scratch.lambda[l][i / 3][i % 3];
    }
    couple<false>(w.A_cross, w.foot[0].impulse, w.foot[1].twist);
    couple<true>(w.A_cross, w.foot[1].impulse, w.foot[0].twist);
  }
  for (int l = 0; l < kNumFeet; ++l) add_twist(w.foot[l].twist, w.foot[l]);
}

/// One Gauss-Seidel sweep over both feet. The other foot must know at once: telling both at the end
/// of the sweep (Jacobi) diverges when the base is light.
template <class T>
inline void sweep_feet(const StepModel& model, StepWork<T>& w, StepScratch<T>& scratch) {
  FootContact<T>&right = w.foot[0], &left = w.foot[1];
  T from_right[6] = {}, from_left[6] = {}, to_left[6] = {}, to_right[6] = {};
  sweep_foot(model.friction_forward, model.friction_sideways, right, scratch.lambda[0][0],
             from_right);
  couple<false>(w.A_cross, from_right, to_left);
  add_twist(to_left, left);
  sweep_foot(model.friction_forward, model.friction_sideways, left, scratch.lambda[1][0],
             from_left);
  couple<true>(w.A_cross, from_left, to_right);
  add_twist(to_right, right);
  for (int i = 0; i < 6; ++i) {
    right.impulse[i] += from_right[i];
    left.impulse[i] += from_left[i];
  }
}

/// (N s)^2, of the lane that is farthest from a solution.
template <class T>
inline double contact_left(const StepModel& model, const StepWork<T>& w,
                           const StepScratch<T>& scratch) {
  T sum = 0.0;
  for (int l = 0; l < kNumFeet; ++l)
    sum += contact_defect(model.friction_forward, model.friction_sideways, w.foot[l],
                          scratch.lambda[l][0]);
  return largest(sum);
}

/// Contact impulses: Gauss-Seidel sweeps find which rows touch, stick and slide, a Newton step
/// solves for them; again until every lane is solved. A lane that was solved before the others
/// stays where it is but for rounding. From a solution nearby the rows are known: a Newton step
/// comes first, and often it is all; from the solution itself there is nothing to do.
template <class T>
inline void solve_contact(const StepModel& model, double h, StepWork<T>& w,
                          StepScratch<T>& scratch) {
  start_contact(model, h, w, scratch);
  const double solved = model.contact.tolerance * model.contact.tolerance;
  if (scratch.warm_start && contact_left(model, w, scratch) <= solved) return;
  T negative_inertia[kTwists][kTwists];
  sole_inertia(w.A, w.A_cross, negative_inertia);
  const auto newton = [&] {
    return largest(newton_step(model.friction_forward, model.friction_sideways,
                               model.contact.regularization, w.A, w.A_cross, negative_inertia,
                               w.foot, scratch.lambda)) <= solved;
  };
  if (scratch.warm_start && newton()) return;
  for (int l = 0; l < kNumFeet; ++l) row_responses(w.A[l], w.foot[l]);
#pragma GCC unroll 1
  for (int round = 0; round < model.contact.rounds; ++round) {
#pragma GCC unroll 1
    for (int sweep = 0; sweep < model.contact.sweeps; ++sweep) sweep_feet(model, w, scratch);
    if (newton()) return;
  }
}

/// Velocities of the corners at the end of the step, from the residuals of their rows.
template <class T>
inline void report_contact(const StepModel& model, double h, const StepWork<T>& w,
                           StepScratch<T>& scratch) {
  const double softness = model.contact.regularization / (1.0 + model.contact.regularization);
  for (int l = 0; l < kNumFeet; ++l)
    for (int i = 0; i < kFootRows; ++i) {
      const FootContact<T>& foot = w.foot[l];
      const T target = i % 3 == 2 ? normal_target(model, h, foot, i / 3) : T(0.0);
      scratch.corner_velocity[l][i / 3][i % 3] =
          foot.residual[i] - target - softness * foot.diagonal[i] * scratch.lambda[l][i / 3][i % 3];
    }
}

/// Velocity change from free motion and contact impulses: substitutes back through base and legs.
template <class T>
inline void velocity_change(StepWork<T>& w, T* dv_base, T (&d_rate)[kNumFeet][6]) {
  for (int l = 0; l < kNumFeet; ++l)
    for (int k = 0; k < 6; ++k)
      for (int i = 0; i < 6; ++i) {
        w.rhs_leg[l][k] += w.foot[l].X[k][i] * w.foot[l].impulse[i];
        w.rhs_base[k] += w.foot[l].G[k][i] * w.foot[l].impulse[i];
      }
  T b[6];
  for (int k = 0; k < 6; ++k) b[k] = w.base_inverse_d[k] * w.rhs_base[k];
  backward6(w.base, b);
  for (int l = 0; l < kNumFeet; ++l) {
    for (int k = 0; k < 6; ++k) {
      T rest = w.rhs_leg[l][k];
      for (int i = 0; i < 6; ++i) rest -= w.leg[l].F[k][i] * b[i];
      d_rate[l][k] = w.inverse_d[l][k] * rest;
    }
    backward6(w.leg[l].M, d_rate[l]);
  }
  for (int i = 0; i < 6; ++i) dv_base[i] = b[i];
}

/// x after `time` [s] with its velocities as they are; `to` may be x.
template <class T>
inline void drift(const T* x, double time, T* to) {
  T turn[3];
  for (int i = 0; i < 3; ++i) {
    to[kXVel + i] = x[kXVel + i];
    to[kXOmega + i] = x[kXOmega + i];
    to[kXPos + i] = x[kXPos + i] + time * x[kXVel + i];
    turn[i] = time * x[kXOmega + i];
  }
  quat_plus(x + kXQuat, turn, to + kXQuat);
  for (int j = 0; j < kNumJoints; ++j) {
    to[kXJointRate + j] = x[kXJointRate + j];
    to[kXJoint + j] = x[kXJoint + j] + time * x[kXJointRate + j];
  }
}

/// x_next: the middle of a step of h with these changes of velocity, then the half that is left.
template <class T>
inline void finish(const T* middle, double h, const T (&R_world_base)[3][3], const T* dv_base,
                   const T (&d_rate)[kNumFeet][6], T* x_next) {
  T x[kNx];
  for (int i = 0; i < kNx; ++i) x[i] = middle[i];
  for (int i = 0; i < 3; ++i) {
    x[kXVel + i] += dot(R_world_base[i], dv_base);
    x[kXOmega + i] += dv_base[3 + i];
  }
  for (int l = 0; l < kNumFeet; ++l)
    for (int j = 0; j < kLegJoints; ++j) {
      const int joint = l * kLegJoints + j;
      x[kXJointRate + joint] += static_cast<double>(kOp3Joints[joint].sign) * d_rate[l][j];
    }
  drift(x, 0.5 * h, x_next);
}

/// Everything of a step but contact, at its middle: factors, soles' inverse inertias and their
/// twists without contact.
template <class T>
inline void free_step(const StepModel& model, const Ground& ground, const T* x, const T* u,
                      double h, StepWork<T>& w) {
  read_state(model, x, w);
  rigid_body(model, w);
  const T above_ground[3] = {x[kXPos], x[kXPos + 1], x[kXPos + 2] - model.ground_height};
#pragma GCC unroll 1
  for (int l = 0; l < kNumFeet; ++l) {
    T R[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    leg_frames<0>(w.leg[l], side_of(l), R, w.frames);
    foot_geometry<T>(model.foot, ground, above_ground, w.R_world_base, w.frames, side_of(l),
                     h * x[kXVel], w.foot[l]);
    foot_jacobian(w.frames, w.leg[l].rate, w.v_base, w.w_base, w.foot[l]);
  }
  servo(model, x, u, h, w);
  factorize(w);
  sole_response(w);
}

/// One implicit step of length h [s]; x and x_next may be the same array.
template <class T>
inline void single_step(const StepModel& model, const Ground& ground, const T* x, const T* u,
                        double h, T* x_next, StepScratch<T>& scratch, StepWork<T>& w) {
  T middle[kNx];
  drift(x, 0.5 * h, middle);
  free_step(model, ground, middle, u, h, w);
  solve_contact(model, h, w, scratch);
  report_contact(model, h, w, scratch);
  velocity_change(w, w.dv_base, w.d_rate);
  finish(middle, h, w.R_world_base, w.dv_base, w.d_rate, x_next);
}

/// f_A: the state after h [s] with the targets u [rad] held, in `substeps` equal implicit steps.
/// Shapes: x (37), u (12).
/// Needs a unit quaternion in x. Bounded work, no allocation. Fails never; far outside its domain
/// it stays finite or not, the caller checks.
template <class T>
inline void analytical_step(const StepModel& model, const Ground& ground, const T* x, const T* u,
                            double h, int substeps, T* x_next, StepScratch<T>& scratch) {
  const double part = h / substeps;
  StepWork<T> w;
  single_step(model, ground, x, u, part, x_next, scratch, w);
  for (int i = 1; i < substeps; ++i)
    single_step(model, ground, x_next, u, part, x_next, scratch, w);
}

}  // namespace sanso::model::SANSO_ISA
