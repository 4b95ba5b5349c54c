// Fixed-size kernels of the backward pass: [A | B] is 36 x 48, Vxx 36 x 36 padded to 40. Per
// instruction set (SANSO_ISA).
#pragma once

#include <cmath>

#include "host/mpc/backward_pass.h"
#include "host/mpc/lanes/column_kernels.h"
#include "host/mpc/lanes/native_vector.h"

namespace sanso::mpc::SANSO_ISA {

inline constexpr int kPacksAB = kColumns / 8;   // 6
inline constexpr int kPacksX = kNdxPadded / 8;  // 5

/// out[r][..] (+)= sum_k left(r, k) right[k][..] for Rows rows and Packs packs of 8 columns.
template <int Rows, int Packs, Start start = Start::at_zero>
inline void multiply_rows(const double* left, int left_row_stride, int left_k_stride,
                          const double* right, int right_stride, int inner, double* out,
                          int out_stride) {
  multiply<Rows, 8 * Packs, start>(left, left_row_stride, left_k_stride, right, right_stride, inner,
                                   out, out_stride);
}

/// out[..] -= factor in[..] over a row of gains.
inline void subtract_row(double factor, const double* in, double* out) {
  for (int c = 0; c < kNdxPadded; c += kWidth<double>)
    store(out + c, load(out + c) - factor * load(in + c));
}

/// Scratch of one stage.
struct alignas(64) StageScratch {
  double T[kNdx][kColumns];    // Vxx [A | B]
  double B[kNdx][16];          // B, rows padded to two packs
  double WB[kNdx][16];         // sigma^2 W B
  double Quu_noise[kNu][16];   // B' WB
  double noise_gradient[16];   // F' WB
  double noise_still;          // F' sigma^2 W F
  double Qu_x[kNu][kColumns];  // [Qux | B'Vxx B]
  double Qxx[kNdxPadded][kNdxPadded];
  double Quu[kNu][kNu];
  double L[kNu][kNu];
  double Qx[kNdxPadded], Qu[kNu], Vx_AB[kColumns];
  bool held[kNu];
};

/// T = Vxx [A | B], four rows at a time so that the accumulators stay in registers.
inline void multiply_value(const Value& value, const StageDerivatives& d, StageScratch& s) {
  for (int r = 0; r < kNdx; r += 4)
    multiply_rows<4, kPacksAB>(&value.Vxx[r][0], kNdxPadded, 1, &d.AB[0][0], kColumns, kNdx,
                               &s.T[r][0], kColumns);
}

/// Rows r .. r+3 of A'T, from the pack that holds the diagonal on: the upper part is enough.
template <int FirstPack>
inline void upper_rows(const StageDerivatives& d, StageScratch& s, int r) {
  multiply_rows<4, kPacksX - FirstPack>(&d.AB[0][r], 1, kColumns, &s.T[0][8 * FirstPack], kColumns,
                                        kNdx, &s.Qxx[r][8 * FirstPack], kNdxPadded);
}

/// Qxx (upper part) and [Qux | Quu] of the dynamics, from T; costs and noise come later.
inline void quadratic_terms(const StageDerivatives& d, StageScratch& s) {
  upper_rows<0>(d, s, 0), upper_rows<0>(d, s, 4);
  upper_rows<1>(d, s, 8), upper_rows<1>(d, s, 12);
  upper_rows<2>(d, s, 16), upper_rows<2>(d, s, 20);
  upper_rows<3>(d, s, 24), upper_rows<3>(d, s, 28);
  upper_rows<4>(d, s, 32);
  for (int r = 0; r < kNu; r += 4)
    multiply_rows<4, kPacksAB>(&d.AB[0][kNdx + r], 1, kColumns, &s.T[0][0], kColumns, kNdx,
                               &s.Qu_x[r][0], kColumns);
}

/// Noise of a channel a coordinate: B' sigma^2 diag(Vxx) [B | F].
inline void noise_by_coordinate(const StageDerivatives& d, const Value& value, double variance,
                                StageScratch& s) {
  double weighted_F[kNdx];
  s.noise_still = 0;
  for (int i = 0; i < kNdx; ++i) {
    const double w = variance * value.Vxx[i][i];
    weighted_F[i] = w * d.F[i];
    s.noise_still += weighted_F[i] * d.F[i];
    for (int j = 0; j < kNu; ++j) {
      s.B[i][j] = d.AB[i][kNdx + j];
      s.WB[i][j] = w * s.B[i][j];
    }
    for (int j = kNu; j < 16; ++j) s.B[i][j] = s.WB[i][j] = 0;
  }
  for (int r = 0; r < kNu; r += 4)
    multiply_rows<4, 2>(&s.B[0][r], 1, 16, &s.WB[0][0], 16, kNdx, &s.Quu_noise[r][0], 16);
  multiply_rows<1, 2>(weighted_F, 0, 1, &s.B[0][0], 16, kNdx, s.noise_gradient, 16);
}

/// Noise of a single channel along F: B' sigma^2 Vxx [B | F], from the products at hand.
inline void noise_along_one(const StageDerivatives& d, const Value& value, double variance,
                            StageScratch& s) {
  s.noise_still = 0;
  for (int j = 0; j < 16; ++j) s.noise_gradient[j] = 0;
  for (int i = 0; i < kNdx; ++i) {
    double VF = 0;
    for (int j = 0; j < kNdx; ++j) VF += value.Vxx[i][j] * d.F[j];
    s.noise_still += variance * d.F[i] * VF;
    for (int j = 0; j < kNu; ++j) s.noise_gradient[j] += variance * d.F[i] * s.T[i][kNdx + j];
  }
  for (int r = 0; r < kNu; ++r)
    for (int j = 0; j < kNu; ++j) s.Quu_noise[r][j] = variance * s.Qu_x[r][kNdx + j];
}

/// Quu, Qu, Qx of the stage, noise included, mu not.
inline void action_value(const BackwardInput& in, int stage, const Value& value, StageScratch& s) {
  const StageDerivatives& d = in.derivatives[stage];
  const StageCost& cost = in.costs[stage];
  multiply_value(value, d, s);
  quadratic_terms(d, s);
  multiply_rows<1, kPacksAB>(value.Vx, 0, 1, &d.AB[0][0], kColumns, kNdx, s.Vx_AB, kColumns);
  if (in.one_noise_channel)
    noise_along_one(d, value, in.sigma * in.sigma, s);
  else
    noise_by_coordinate(d, value, in.sigma * in.sigma, s);

  for (int i = 0; i < kNdx; ++i) s.Qx[i] = cost.lx[i] + s.Vx_AB[i];
  for (int i = 0; i < kNu; ++i) {
    s.Qu[i] = cost.lu[i] + s.Vx_AB[kNdx + i] + s.noise_gradient[i];
    for (int j = 0; j < kNu; ++j) s.Quu[i][j] = s.Qu_x[i][kNdx + j] + s.Quu_noise[i][j];
    s.Quu[i][i] += cost.luu_diagonal[i];
  }
  for (int i = 0; i < kNdx; ++i)
    if (i < kTheta || i >= kTheta + 3) s.Qxx[i][i] += cost.lxx_diagonal[i];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) s.Qxx[kTheta + i][kTheta + j] += cost.lxx_theta[i][j];
}

/// What noise columns add to the stage's quadratic.
[[gnu::noinline, gnu::cold]] inline void add_columns(const ColumnsPrice& price, StageScratch& s) {
  for (int i = 0; i < kNdx; ++i) {
    s.Qx[i] += price.slope[i];
    for (int j = i; j < kNdx; ++j) s.Qxx[i][j] += price.curvature[i][j];
  }
  for (int i = 0; i < kNu; ++i) {
    const double* row = price.curvature[kNdx + i];
    s.Qu[i] += price.slope[kNdx + i];
    for (int j = 0; j < kNdx; ++j) s.Qu_x[i][j] += row[j];
    for (int j = 0; j < kNu; ++j) s.Quu[i][j] += row[kNdx + j];
  }
}

/// What the noise of a stage costs, as a quadratic in the change of its input.
inline void price_of_noise(const StageScratch& s, NoisePrice& out) {
  out.still = s.noise_still;
  for (int i = 0; i < kNu; ++i) {
    out.slope[i] = s.noise_gradient[i];
    for (int j = 0; j < kNu; ++j) out.curvature[i][j] = s.Quu_noise[i][j];
  }
}

/// Cholesky factor of Quu + mu I with held inputs replaced by unit rows. False when not positive
/// definite.
inline bool factorize(StageScratch& s, double mu) {
  for (int j = 0; j < kNu; ++j) {
    for (int i = j; i < kNu; ++i) {
      double sum =
          (s.held[i] || s.held[j]) ? (i == j ? 1.0 : 0.0) : s.Quu[i][j] + (i == j ? mu : 0.0);
      for (int k = 0; k < j; ++k) sum -= s.L[i][k] * s.L[j][k];
      if (i == j) {
        if (!(sum > 1e-12)) return false;
        s.L[j][j] = std::sqrt(sum);
      } else {
        s.L[i][j] = sum / s.L[j][j];
      }
    }
  }
  return true;
}

/// k = -Quu^-1 Qu and K = -Quu^-1 Qux by two triangular solves over whole rows.
inline void solve_gains(StageScratch& s, StageGains& g) {
  for (int i = 0; i < kNu; ++i) {
    g.k[i] = s.held[i] ? 0.0 : -s.Qu[i];
    for (int j = 0; j < kNdxPadded; ++j) g.K[i][j] = s.held[i] ? 0.0 : -s.Qu_x[i][j];
    for (int j = kNdx; j < kNdxPadded; ++j) g.K[i][j] = 0;  // those columns held B'Vxx B
  }
  const auto eliminate = [&](int i, int j, double l) {
    g.k[i] -= l * g.k[j];
    subtract_row(l, g.K[j], g.K[i]);
  };
  const auto scale = [&](int i) {
    const double r = 1.0 / s.L[i][i];
    g.k[i] *= r;
    for (int j = 0; j < kNdxPadded; ++j) g.K[i][j] *= r;
  };
  for (int i = 0; i < kNu; ++i) {
    for (int j = 0; j < i; ++j) eliminate(i, j, s.L[i][j]);
    scale(i);
  }
  for (int i = kNu - 1; i >= 0; --i) {
    for (int j = i + 1; j < kNu; ++j) eliminate(i, j, s.L[j][i]);
    scale(i);
  }
}

/// Rows r .. r+3 of Qxx += K' (Qux - mu K), upper part.
template <int FirstPack>
inline void add_gain_rows(const StageGains& g, const double (&R)[kNu][kNdxPadded], StageScratch& s,
                          int r) {
  multiply_rows<4, kPacksX - FirstPack, Start::at_out>(&g.K[0][r], 1, kNdxPadded,
                                                       &R[0][8 * FirstPack], kNdxPadded, kNu,
                                                       &s.Qxx[r][8 * FirstPack], kNdxPadded);
}

/// V of the knot before the stage. With k, K exact solutions for Quu + mu I the usual sums shrink
/// to
/// Vxx = Qxx + K'(Qux - mu K),  Vx = Qx + Qux'k - mu K'k  (on the free inputs; the held ones have
/// zero rows).
inline void value_before(StageScratch& s, const StageGains& g, double mu, Value& value) {
  alignas(64) double R[kNu][kNdxPadded];  // Qux - mu K
  for (int i = 0; i < kNu; ++i)
    for (int j = 0; j < kNdxPadded; ++j) R[i][j] = j < kNdx ? s.Qu_x[i][j] - mu * g.K[i][j] : 0.0;
  add_gain_rows<0>(g, R, s, 0), add_gain_rows<0>(g, R, s, 4);
  add_gain_rows<1>(g, R, s, 8), add_gain_rows<1>(g, R, s, 12);
  add_gain_rows<2>(g, R, s, 16), add_gain_rows<2>(g, R, s, 20);
  add_gain_rows<3>(g, R, s, 24), add_gain_rows<3>(g, R, s, 28);
  add_gain_rows<4>(g, R, s, 32);
  for (int i = 0; i < kNdx; ++i) {
    double sum = s.Qx[i];
    for (int j = 0; j < kNu; ++j) sum += R[j][i] * g.k[j];
    value.Vx[i] = sum;
  }
  // the upper part is the truth; mirrored, so that rounding cannot make Vxx unsymmetric
  for (int i = 0; i < kNdx; ++i)
    for (int j = i; j < kNdx; ++j) value.Vxx[i][j] = value.Vxx[j][i] = s.Qxx[i][j];
}

/// An input at its limit that the gradient pushes outwards stays there.
inline void hold_inputs_at_limits(const double* u, double limit, StageScratch& s) {
  for (int i = 0; i < kNu; ++i)
    s.held[i] = (u[i] >= limit && s.Qu[i] < 0) || (u[i] <= -limit && s.Qu[i] > 0);
}

/// The value after the last knot: its cost alone.
inline void start_value(const StageCost& last, Value& value) {
  value = Value{};
  for (int i = 0; i < kNdx; ++i) {
    value.Vx[i] = last.lx[i];
    if (i < kTheta || i >= kTheta + 3) value.Vxx[i][i] = last.lxx_diagonal[i];
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) value.Vxx[kTheta + i][kTheta + j] = last.lxx_theta[i][j];
}

/// From the last knot to the first. Not ok: some Quu + mu I was not positive definite, or the
/// expected change is not finite; gains before that stage are not written.
inline BackwardSummary run_backward_pass(const BackwardInput& in, const BackwardOutput& out,
                                         Value& value) {
  BackwardSummary summary;
  StageScratch s;
  start_value(in.costs[in.stages], value);
  for (int stage = in.stages - 1; stage >= 0; --stage) {
    if (in.wait_for) in.wait_for(in.wait_context, stage);
    action_value(in, stage, value, s);
    price_of_noise(s, out.noise[stage]);
    if (in.columns) {
      price_of_columns(*in.columns, stage, value, out.columns[stage]);
      add_columns(out.columns[stage], s);
    }
    hold_inputs_at_limits(in.u[stage], in.input_limit_rad, s);
    if (!factorize(s, in.mu)) return summary;
    StageGains& g = out.gains[stage];
    solve_gains(s, g);
    for (int i = 0; i < kNu; ++i) {
      summary.linear += g.k[i] * s.Qu[i];
      for (int j = 0; j < kNu; ++j) summary.quadratic += 0.5 * g.k[i] * s.Quu[i][j] * g.k[j];
    }
    value_before(s, g, in.mu, value);
  }
  summary.ok = std::isfinite(summary.linear);
  return summary;
}

}  // namespace sanso::mpc::SANSO_ISA
