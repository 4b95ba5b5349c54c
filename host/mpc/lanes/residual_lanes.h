// The residual network in single precision: eight evaluations at once for roll-outs, and its exact Jacobian by the chain
// rule for the linearisation (cheaper than differencing it: 295 k products against 465 k and no softplus). Per
// instruction set. Vectors run along the hidden units, so a weight is loaded once for several states.
#pragma once

#include "host/mpc/residual_weights.h"

namespace sanso::mpc::SANSO_ISA {

using Floats = float __attribute__((vector_size(64)));  // 16
using FloatsUnaligned = float __attribute__((vector_size(64), aligned(4), may_alias));
using FloatBits = int __attribute__((vector_size(64)));

inline Floats load16(const float* p) { return *reinterpret_cast<const FloatsUnaligned*>(p); }
inline void store16(float* p, Floats v) { *reinterpret_cast<FloatsUnaligned*>(p) = v; }

/// softplus(a) = log(1 + e^a) and its slope 1 / (1 + e^-a); relative error a few 1e-7.
inline Floats softplus(Floats a, Floats& slope) {
  const Floats magnitude = a < 0 ? a : -a;                       // -|a|
  const Floats clamped = magnitude < -80.0f ? Floats{} - 80.0f : magnitude;
  // e = exp(-|a|) = 2^n e^r
  const float magic = 12582912.0f;  // 1.5 x 2^23: rounds to the nearest whole number
  const Floats n = (clamped * 1.44269504f + magic) - magic;
  const Floats r = (clamped - n * 0.693359375f) + n * 2.12194440e-4f;
  Floats e = Floats{} + 1.0f;
  for (int k = 7; k >= 1; --k) e = 1.0f + r * (1.0f / static_cast<float>(k)) * e;
  const FloatBits bits = (__builtin_convertvector(n, FloatBits) + 127) << 23;
  e *= __builtin_bit_cast(Floats, bits);
  // log(1 + e) = 2 atanh(s), s = e / (2 + e) <= 1/3
  const Floats s = e / (2.0f + e), s2 = s * s;
  Floats log1p = Floats{} + 1.0f / 15;
  for (int k = 13; k >= 1; k -= 2) log1p = 1.0f / static_cast<float>(k) + s2 * log1p;
  log1p *= 2.0f * s;
  slope = (a < 0 ? e : Floats{} + 1.0f) / (1.0f + e);
  return (a > 0 ? a : Floats{}) + log1p;
}

/// out[r][..] = bias[..] + sum_k in(r, k) W[k][..] for Rows states and Packs packs of 16 units.
template <int Rows, int Packs>
inline void layer(const float* in, int in_row_stride, int in_k_stride, int inner, const float* weights, int weight_stride,
                  const float* bias, float* out, int out_stride) {
  Floats sum[Rows][Packs];
  for (int r = 0; r < Rows; ++r)
    for (int c = 0; c < Packs; ++c) sum[r][c] = bias ? load16(bias + 16 * c) : Floats{};
  for (int k = 0; k < inner; ++k) {
    Floats w[Packs];
    for (int c = 0; c < Packs; ++c) w[c] = load16(weights + k * weight_stride + 16 * c);
    for (int r = 0; r < Rows; ++r) {
      const Floats s = Floats{} + in[r * in_row_stride + k * in_k_stride];
      for (int c = 0; c < Packs; ++c) sum[r][c] += s * w[c];
    }
  }
  for (int r = 0; r < Rows; ++r)
    for (int c = 0; c < Packs; ++c) store16(out + r * out_stride + 16 * c, sum[r][c]);
}

/// Eight evaluations: features[lane][48] -> output[lane][48] (36 used), base axes, SI.
inline void residual_lanes(const ResidualWeights& w, const float (&features)[8][kFeaturesPadded],
                           float (&output)[8][kOutputsPadded]) {
  alignas(64) float h1[8][kHiddenUnits], h2[8][kHiddenUnits];
  Floats slope;
  for (int r = 0; r < 8; r += 4)
    layer<4, 4>(&features[r][0], kFeaturesPadded, 1, kFeatureCount, &w.W1[0][0], kHiddenUnits, w.b1, &h1[r][0], kHiddenUnits);
  for (int i = 0; i < 8 * kHiddenUnits; i += 16) store16(&h1[0][0] + i, softplus(load16(&h1[0][0] + i), slope));
  for (int r = 0; r < 8; r += 4)
    layer<4, 4>(&h1[r][0], kHiddenUnits, 1, kHiddenUnits, &w.W2[0][0], kHiddenUnits, w.b2, &h2[r][0], kHiddenUnits);
  for (int i = 0; i < 8 * kHiddenUnits; i += 16) store16(&h2[0][0] + i, softplus(load16(&h2[0][0] + i), slope));
  for (int r = 0; r < 8; r += 4)
    layer<4, 3>(&h2[r][0], kHiddenUnits, 1, kHiddenUnits, &w.W3[0][0], kOutputsPadded, w.b3, &output[r][0], kOutputsPadded);
}

/// One evaluation.
inline void residual_single(const ResidualWeights& w, const float (&features)[kFeaturesPadded],
                            float (&output)[kOutputsPadded]) {
  alignas(64) float h1[kHiddenUnits], h2[kHiddenUnits];
  Floats slope;
  layer<1, 4>(features, 0, 1, kFeatureCount, &w.W1[0][0], kHiddenUnits, w.b1, h1, kHiddenUnits);
  for (int i = 0; i < kHiddenUnits; i += 16) store16(h1 + i, softplus(load16(h1 + i), slope));
  layer<1, 4>(h1, 0, 1, kHiddenUnits, &w.W2[0][0], kHiddenUnits, w.b2, h2, kHiddenUnits);
  for (int i = 0; i < kHiddenUnits; i += 16) store16(h2 + i, softplus(load16(h2 + i), slope));
  layer<1, 3>(h2, 0, 1, kHiddenUnits, &w.W3[0][0], kOutputsPadded, w.b3, output, kOutputsPadded);
}

/// Output and d output / d features (36 x 48, the last two columns zero) at one point.
inline void residual_jacobian(const ResidualWeights& w, const float (&features)[kFeaturesPadded],
                              float (&output)[kOutputsPadded], float (&J)[kOutputCount][kFeaturesPadded]) {
  alignas(64) float a1[kHiddenUnits], a2[kHiddenUnits], d1[kHiddenUnits], d2[kHiddenUnits];
  alignas(64) float J1[kHiddenUnits][kFeaturesPadded], J2[kHiddenUnits][kFeaturesPadded];
  const auto activate = [](float* a, float* d) {
    for (int i = 0; i < kHiddenUnits; i += 16) {
      Floats slope;
      store16(a + i, softplus(load16(a + i), slope));
      store16(d + i, slope);
    }
  };
  layer<1, 4>(features, 0, 1, kFeatureCount, &w.W1[0][0], kHiddenUnits, w.b1, a1, kHiddenUnits);
  activate(a1, d1);
  layer<1, 4>(a1, 0, 1, kHiddenUnits, &w.W2[0][0], kHiddenUnits, w.b2, a2, kHiddenUnits);
  activate(a2, d2);
  layer<1, 3>(a2, 0, 1, kHiddenUnits, &w.W3[0][0], kOutputsPadded, w.b3, output, kOutputsPadded);
  // J1 = diag(d1) W1, J2 = diag(d2) W2 J1, J = W3 J2
  for (int i = 0; i < kHiddenUnits; ++i)
    for (int c = 0; c < kFeaturesPadded; c += 16) store16(&J1[i][c], d1[i] * load16(&w.W1_by_unit[i][c]));
  for (int i = 0; i < kHiddenUnits; i += 8) {
    layer<8, 3>(&w.W2[0][i], 1, kHiddenUnits, kHiddenUnits, &J1[0][0], kFeaturesPadded, nullptr, &J2[i][0], kFeaturesPadded);
    for (int r = i; r < i + 8; ++r)
      for (int c = 0; c < kFeaturesPadded; c += 16) store16(&J2[r][c], d2[r] * load16(&J2[r][c]));
  }
  for (int i = 0; i < kOutputCount; i += 6)
    layer<6, 3>(&w.W3[0][i], 1, kOutputsPadded, kHiddenUnits, &J2[0][0], kFeaturesPadded, nullptr, &J[i][0], kFeaturesPadded);
}

}  // namespace sanso::mpc::SANSO_ISA
