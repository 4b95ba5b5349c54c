// What one step leaves behind so that steps from states nearby need not repeat it. Its set of
// touching, sticking and sliding rows does not change to first order; mass matrix and soles change
// with the configuration at its middle only. Plain numbers, shared by all instruction sets.
#pragma once

#include "shared/model/dimensions.h"

namespace sanso::model {

/// Leg index 0 right, 1 left; joints about the positive coordinate axes; twists and wrenches of a
/// sole in contact axes.
struct NominalStep {
  double height, v_world[3];  // m, m/s: of the base: at the middle, at the beginning
  double R_world_base[3][3];  // [row][column]
  // rad/s; m/s^2, acceleration of the base that stands for gravity; base axes
  double w_base[3], a_base[3];
  double cosine[kNumFeet][6], sine[kNumFeet][6];
  double rate[kNumFeet][6];      // rad/s at the beginning
  double bias_on_base[6];        // N, N m
  double rhs_leg[kNumFeet][6];   // N m s: right-hand sides of the legs, before elimination
  double implicit[kNumFeet][6];  // kg m^2: h/2 D + h^2/4 K of the servos
  double leg_factor[kNumFeet][6][6], leg_inverse_d[kNumFeet][6];  // L D L' of the effective inertia
  double base_factor[6][6], base_inverse_d[6];
  // L^-1 of the coupling with the base           [joint][base]
  double F[kNumFeet][6][6];
  // L^-1 of the transposed Jacobian of the sole  [joint][twist]
  double X[kNumFeet][6][6];
  // the same of the base                         [base][twist]
  double G[kNumFeet][6][6];
  double dv_base[6], d_rate[kNumFeet][6];  // velocity changes of the step
  // contact with the set of rows held
  double lambda[kNumFeet][kCornersPerFoot][3];  // N s
  double weight[kNumFeet][kCornersPerFoot][3];  // impulse per velocity of a free row, else 0
  double slide[kNumFeet][kCornersPerFoot][2];   // a sliding tangent per its normal, else 0
  // of the equations for the twists (contact_newton.h)
  double factor[2 * 6][2 * 6];
  // impulses of both soles per change of their free twists
  double contact[2 * 6][2 * 6];
  double contact_by_height[2 * 6];  // and per metre of height
  double contact_by_speed[2 * 6];   // and per m/s along world x, of wheels in a bend
};

}  // namespace sanso::model
