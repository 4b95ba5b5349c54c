// What one step of the whole body works on: its scratch memory, and the state as the step reads it.
// Like all of kernel/, built once for every instruction set.
#pragma once

#include "shared/model/kernel/contact_newton.h"

namespace sanso::model::SANSO_ISA {

/// What a step leaves behind, and what the next may start from.
template <class T>
struct StepScratch {
  // N s: impulses of the last substep; contact axes (forward, across, normal)
  T lambda[kNumFeet][kCornersPerFoot][3] = {};
  T gap[kNumFeet][kCornersPerFoot] = {};                 // m, at the middle of the last substep
  T corner_velocity[kNumFeet][kCornersPerFoot][3] = {};  // m/s at its end, contact axes
  // begin the contact solver from `lambda` instead of from zero
  bool warm_start = false;
};

template <class T>
struct StepWork {
  T R_world_base[3][3];  // [row][column]
  T v_base[3], w_base[3];
  Leg<T> leg[kNumFeet];
  LegFrames<T> frames;
  FootContact<T> foot[kNumFeet];
  T inverse_d[kNumFeet][6], base_inverse_d[6];
  T base[6][6];    // effective inertia of the base, then its factor
  T bias_base[6];  // N, N m: force and moment of the whole robot at zero acceleration
  T rhs_leg[kNumFeet][6], rhs_base[6];
  // inverse inertias of the soles; A_cross: right rows, left columns
  T A[kNumFeet][6][6], A_cross[6][6];
  T dv_base[6], d_rate[kNumFeet][6];  // velocity changes of the step: base (base axes), joints
};

/// Sign of y on a leg: right -1, left +1.
constexpr double side_of(int leg) { return leg == 0 ? -1.0 : 1.0; }

template <class T>
inline void rotation_from_quat(const T* q, T (&R)[3][3]) {
  const T w = q[0], x = q[1], y = q[2], z = q[3];
  R[0][0] = 1.0 - 2.0 * (y * y + z * z);
  R[0][1] = 2.0 * (x * y - w * z);
  R[0][2] = 2.0 * (x * z + w * y);
  R[1][0] = 2.0 * (x * y + w * z);
  R[1][1] = 1.0 - 2.0 * (x * x + z * z);
  R[1][2] = 2.0 * (y * z - w * x);
  R[2][0] = 2.0 * (x * z - w * y);
  R[2][1] = 2.0 * (y * z + w * x);
  R[2][2] = 1.0 - 2.0 * (x * x + y * y);
}

/// Base velocities in base axes; joint angles (less what the servo's zero is off) and rates about
/// the positive coordinate axes.
template <class T>
inline void read_state(const StepModel& model, const T* x, StepWork<T>& w) {
  rotation_from_quat(x + kXQuat, w.R_world_base);
  for (int i = 0; i < 3; ++i) {
    w.v_base[i] = w.R_world_base[0][i] * x[kXVel] + w.R_world_base[1][i] * x[kXVel + 1] +
                  w.R_world_base[2][i] * x[kXVel + 2];
    w.w_base[i] = x[kXOmega + i];
  }
  for (int leg = 0; leg < kNumFeet; ++leg)
    for (int j = 0; j < kLegJoints; ++j) {
      const int joint = leg * kLegJoints + j;
      const double sign = kOp3Joints[joint].sign;
      sincos(sign * (x[kXJoint + joint] - model.servo[joint].zero), w.leg[leg].s[j],
             w.leg[leg].c[j]);
      w.leg[leg].rate[j] = sign * x[kXJointRate + joint];
    }
}

}  // namespace sanso::model::SANSO_ISA
