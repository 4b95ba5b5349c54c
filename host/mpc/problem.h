// The numbers that pass between the phases of the solver: trajectories, derivatives and gains, in
// fixed storage.
// Layouts are plain row-major arrays, 64-byte aligned, so that the kernels of every instruction set
// read them directly.
// No Eigen here or in lanes/: its types change their alignment with the instruction set they are
// compiled for.
#pragma once

#include "host/mpc/mpc_settings.h"
#include "shared/model/dimensions.h"

namespace sanso::mpc {

using model::kNdx, model::kNu, model::kNx;
inline constexpr int kTheta = model::kDTheta;
// columns of [A | B]: 36 tangent directions, 12 inputs
inline constexpr int kColumns = kNdx + kNu;
inline constexpr int kMaxStages = kMaxHorizon - 1;  // steps between the states of the horizon
inline constexpr int kNxPadded = 40, kNuPadded = 16;
// row length of square tangent matrices: a multiple of 8 lanes
inline constexpr int kNdxPadded = 40;
inline constexpr int kLineSearchLanes = 8;  // step lengths tried at once
inline constexpr int kRollOutLanes = 4;     // of them, rolled out in step by one thread
inline constexpr int kRollOutGroups = kLineSearchLanes / kRollOutLanes;

/// States and upper-layer inputs of one roll-out. u[k] leads from x[k] to x[k+1].
struct alignas(64) Trajectory {
  double x[kMaxHorizon][kNxPadded];  // state in the order of state_layout.h
  double u[kMaxStages][kNuPadded];   // u_up, rad
};

/// x[k+1] ⊖ x̄[k+1] = A (x[k] ⊖ x̄[k]) + B (u[k] - ū[k]) and the noise direction at the nominal
/// point.
struct alignas(64) StageDerivatives {
  double AB[kNdx][kColumns];  // [A | B]
  // f(x, u) ⊖ f(x, u without u_up); multiplied by sigma where it is used
  double F[kNdx];
};

/// Second-order model of the stage cost on the tangent at x̄[k], ū[k] (derivatives, hence the
/// factors 2).
struct alignas(64) StageCost {
  double lx[kNdxPadded];
  double lxx_diagonal[kNdxPadded];  // all but the orientation block
  // orientation block, not diagonal: J' W J with J of the logarithm
  double lxx_theta[3][3];
  double lu[kNu];
  double luu_diagonal[kNu];
};

/// What the noise of a stage costs when u leaves the nominal input by du, sigma^2 included:
/// (still + 2 slope'du + du'curvature du) / 2.
struct alignas(64) NoisePrice {
  double still;
  double slope[kNu];
  double curvature[kNu][kNu];
};

/// Feedforward and feedback of one stage: u = ū + alpha k + K (x ⊖ x̄).
struct alignas(64) StageGains {
  double k[kNu];
  double K[kNu][kNdxPadded];
};

/// Value function at one knot: V(d) = V0 + Vx' d + d' Vxx d / 2.
struct alignas(64) Value {
  double Vx[kNdxPadded];
  double Vxx[kNdxPadded][kNdxPadded];  // symmetric, padding zero
};

}  // namespace sanso::mpc
