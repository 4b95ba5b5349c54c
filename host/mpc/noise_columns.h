// Noise whose size changes with state and input: columns of F with their derivatives, each with a
// number w of its own, or with one number a coordinate.
#pragma once

#include "host/mpc/problem.h"

namespace sanso::mpc {

inline constexpr int kMaxSpread = 8;  // models beside the one that is planned with
inline constexpr int kMaxNoiseColumns = 1 + kMaxSpread;

/// One column of F about the nominal point of a stage: c + D (dx, du).
struct alignas(64) NoiseColumn {
  double D[kNdx][kColumns];
  double c[kNdxPadded];
};
struct StageNoise {
  NoiseColumn column[kMaxNoiseColumns];
};

/// The columns of all stages; none: `count` 0.
struct NoiseColumns {
  int count = 0;
  const StageNoise* stage = nullptr;          // [stages]
  double variance[kMaxNoiseColumns] = {};     // sigma^2 of each
  bool by_coordinate[kMaxNoiseColumns] = {};  // w is a vector, F diagonal
  bool of_input = false;  // the noise that inputs make is among them, and priced nowhere else
};

/// What the columns of a stage cost at d = (dx, du) from its nominal point, sigma^2 included:
/// (at + 2 slope'd + d'curvature d) / 2.
struct alignas(64) ColumnsPrice {
  double at;
  double slope[kColumns];
  double curvature[kColumns][kColumns];
};

}  // namespace sanso::mpc
