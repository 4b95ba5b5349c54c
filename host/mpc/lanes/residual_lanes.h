// The residual network in single precision: a group of evaluations at once for roll-outs, and its
// exact Jacobian by the chain rule for the linearisation (cheaper than differencing it: 295 k
// products against 465 k and no softplus). Per instruction set. Vectors run along the hidden units,
// so a weight is loaded once for several states.
#pragma once

#include <algorithm>

#include "host/mpc/lanes/native_vector.h"
#include "host/mpc/residual_weights.h"

namespace sanso::mpc::SANSO_ISA {

/// softplus(a) = log(1 + e^a) and its slope 1 / (1 + e^-a); relative error a few 1e-7.
inline Floats softplus(Floats a, Floats& slope) {
  const Floats magnitude = a < 0 ? a : -a;  // -|a|
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

/// out[r][..] = bias[..] + sum_k in(r, k) W[k][..] for Rows states and Units units.
template <int Rows, int Units>
inline void layer(const float* in, int in_row_stride, const float* weights, int inner,
                  const float* bias, float* out) {
  for (int r = 0; r < Rows; ++r) std::copy_n(bias, Units, out + r * Units);
  multiply<Rows, Units, Start::at_out>(in, in_row_stride, 1, weights, Units, inner, out, Units);
}

/// a = softplus(a) for `count` units (a multiple of 16).
inline void activate(float* a, int count) {
  Floats slope;
  for (int i = 0; i < count; i += kWidth<float>) store(a + i, softplus(load(a + i), slope));
}

/// A group's evaluations: features[lane][48] -> output[lane][48] (36 used), base axes, SI.
inline void residual_lanes(const ResidualWeights& w,
                           const float (&features)[kRollOutLanes][kFeaturesPadded],
                           float (&output)[kRollOutLanes][kOutputsPadded]) {
  alignas(64) float h1[kRollOutLanes][kHiddenUnits], h2[kRollOutLanes][kHiddenUnits];
  layer<kRollOutLanes, kHiddenUnits>(features[0], kFeaturesPadded, &w.W1[0][0], kFeatureCount, w.b1,
                                     h1[0]);
  activate(&h1[0][0], kRollOutLanes * kHiddenUnits);
  layer<kRollOutLanes, kHiddenUnits>(h1[0], kHiddenUnits, &w.W2[0][0], kHiddenUnits, w.b2, h2[0]);
  activate(&h2[0][0], kRollOutLanes * kHiddenUnits);
  layer<kRollOutLanes, kOutputsPadded>(h2[0], kHiddenUnits, &w.W3[0][0], kHiddenUnits, w.b3,
                                       output[0]);
}

/// One evaluation.
inline void residual_single(const ResidualWeights& w, const float (&features)[kFeaturesPadded],
                            float (&output)[kOutputsPadded]) {
  alignas(64) float h1[kHiddenUnits], h2[kHiddenUnits];
  layer<1, kHiddenUnits>(features, 0, &w.W1[0][0], kFeatureCount, w.b1, h1);
  activate(h1, kHiddenUnits);
  layer<1, kHiddenUnits>(h1, 0, &w.W2[0][0], kHiddenUnits, w.b2, h2);
  activate(h2, kHiddenUnits);
  layer<1, kOutputsPadded>(h2, 0, &w.W3[0][0], kHiddenUnits, w.b3, output);
}

/// out[i] = factor * in[i] for a row of `count` numbers.
inline void scale_row(float factor, const float* in, float* out, int count) {
  for (int c = 0; c < count; c += kWidth<float>) store(out + c, factor * load(in + c));
}

/// Whether no unit's slope differs by more than `tolerance`.
inline bool slopes_near(const float* a, const float* b, float tolerance) {
  Floats largest{};
  for (int i = 0; i < kHiddenUnits; i += kWidth<float>) {
    const Floats d = load(a + i) - load(b + i), size = d < 0 ? -d : d;
    largest = size > largest ? size : largest;
  }
  for (int i = 0; i < kWidth<float>; ++i)
    if (!(largest[i] <= tolerance)) return false;
  return true;
}

/// d output / d features from the slopes in `kept`.
inline void chain_rule(const ResidualWeights& w, KeptJacobian& kept) {
  alignas(64) float V3[kHiddenUnits][kOutputsPadded], V2[kOutputCount][kHiddenUnits];
  // J = (W3 diag(d2)) W2 diag(d1) W1 from the left: the outputs are fewer than the units
  for (int i = 0; i < kHiddenUnits; ++i) scale_row(kept.slope2[i], w.W3[i], V3[i], kOutputsPadded);
  constexpr int kRows = kVectorBytes == 64 ? 6 : 4;  // what the registers hold
  for (int i = 0; i < kOutputCount; i += kRows) {
    multiply<kRows, kHiddenUnits, Start::at_zero>(&V3[0][i], 1, kOutputsPadded, &w.W2_by_unit[0][0],
                                                  kHiddenUnits, kHiddenUnits, V2[i], kHiddenUnits);
    for (int r = i; r < i + kRows; ++r)
      for (int c = 0; c < kHiddenUnits; c += kWidth<float>)
        store(V2[r] + c, load(V2[r] + c) * load(kept.slope1 + c));
    multiply<kRows, kFeaturesPadded, Start::at_zero>(V2[i], kHiddenUnits, 1, &w.W1_by_unit[0][0],
                                                     kFeaturesPadded, kHiddenUnits, kept.J[i],
                                                     kFeaturesPadded);
  }
}

/// Output at one point, and the Jacobian there or, when no unit's slope (0 to 1) differs by more
/// than kNear, the one in `kept`: it takes twenty times the work of the output.
inline void residual_jacobian(const ResidualWeights& w, const float (&features)[kFeaturesPadded],
                              float (&output)[kOutputsPadded], KeptJacobian& kept) {
  constexpr float kNear = 0.02f;
  alignas(64) float a1[kHiddenUnits], a2[kHiddenUnits], d1[kHiddenUnits], d2[kHiddenUnits];
  const auto activate_with_slope = [](float* a, float* d) {
    for (int i = 0; i < kHiddenUnits; i += kWidth<float>) {
      Floats slope;
      store(a + i, softplus(load(a + i), slope));
      store(d + i, slope);
    }
  };
  layer<1, kHiddenUnits>(features, 0, &w.W1[0][0], kFeatureCount, w.b1, a1);
  activate_with_slope(a1, d1);
  layer<1, kHiddenUnits>(a1, 0, &w.W2[0][0], kHiddenUnits, w.b2, a2);
  activate_with_slope(a2, d2);
  layer<1, kOutputsPadded>(a2, 0, &w.W3[0][0], kHiddenUnits, w.b3, output);
  if (kept.present && slopes_near(d1, kept.slope1, kNear) && slopes_near(d2, kept.slope2, kNear))
    return;
  std::copy_n(d1, kHiddenUnits, kept.slope1);
  std::copy_n(d2, kHiddenUnits, kept.slope2);
  kept.present = true;
  chain_rule(w, kept);
}

}  // namespace sanso::mpc::SANSO_ISA
