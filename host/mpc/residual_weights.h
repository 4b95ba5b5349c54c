// The residual network as the lane kernels read it: single precision, transposed (input by unit),
// standardisation folded into the first and last layer, rows padded to whole packs of 16. Plain
// arrays: shared by all instruction sets.
#pragma once

namespace sanso::host {
struct ResidualNetwork;
}

namespace sanso::mpc {

inline constexpr int kFeatureCount = 46, kFeaturesPadded = 48, kHiddenUnits = 64, kOutputCount = 36,
                     kOutputsPadded = 48;

struct alignas(64) ResidualWeights {
  bool present = false;
  float W1[kFeatureCount][kHiddenUnits];            // [feature][unit]
  float W1_by_unit[kHiddenUnits][kFeaturesPadded];  // the same, transposed: rows of the Jacobian
  float W2[kHiddenUnits][kHiddenUnits];             // [unit below][unit above]
  float W2_by_unit[kHiddenUnits][kHiddenUnits];     // the same, transposed
  float W3[kHiddenUnits][kOutputsPadded];           // [unit][output]
  float b1[kHiddenUnits], b2[kHiddenUnits], b3[kOutputsPadded];
};

/// The network's Jacobian at a point of a stage, kept for the points nearby: all that it depends on
/// are the slopes of the units.
struct alignas(64) KeptJacobian {
  float slope1[kHiddenUnits], slope2[kHiddenUnits];
  float J[kOutputCount][kFeaturesPadded];  // d output / d feature, the last two columns zero
  bool present = false;
};

/// `network` with its standardisation folded in.
void fold(const host::ResidualNetwork& network, ResidualWeights& out);

}  // namespace sanso::mpc
