// Price of noise columns under a value function. Per instruction set (SANSO_ISA).
#pragma once

#include "host/mpc/lanes/native_vector.h"
#include "host/mpc/noise_columns.h"

namespace sanso::mpc::SANSO_ISA {

/// variance W [D | c], with W = Vxx, or its diagonal where every coordinate has its own channel.
inline void weigh_column(const NoiseColumn& n, const Value& value, double variance, bool diagonal,
                         double (&WD)[kNdx][kColumns], double (&Wc)[kNdx]) {
  if (diagonal) {
    for (int i = 0; i < kNdx; ++i) {
      const double w = variance * value.Vxx[i][i];
      Wc[i] = w * n.c[i];
      for (int j = 0; j < kColumns; ++j) WD[i][j] = w * n.D[i][j];
    }
    return;
  }
  for (int r = 0; r < kNdx; r += 4)
    multiply<4, kColumns, Start::at_zero>(&value.Vxx[r][0], kNdxPadded, 1, &n.D[0][0], kColumns,
                                          kNdx, WD[r], kColumns);
  for (int i = 0; i < kNdx; ++i) {
    Wc[i] = 0;
    for (int j = 0; j < kNdx; ++j) Wc[i] += variance * value.Vxx[i][j] * n.c[j];
    for (int j = 0; j < kColumns; ++j) WD[i][j] *= variance;
  }
}

/// Sum over the columns of variance [c | D]' W [c | D]. Out of line: inside the backward pass it
/// took more than a tenth of the time of a pass that does not ask for it.
[[gnu::noinline]] inline void price_of_columns(const NoiseColumns& columns, int stage,
                                               const Value& value, ColumnsPrice& out) {
  alignas(64) double WD[kNdx][kColumns];
  double Wc[kNdx];
  out = ColumnsPrice{};
  for (int e = 0; e < columns.count; ++e) {
    const NoiseColumn& n = columns.stage[stage].column[e];
    weigh_column(n, value, columns.variance[e], columns.by_coordinate[e], WD, Wc);
    for (int i = 0; i < kNdx; ++i) {
      out.at += n.c[i] * Wc[i];
      for (int j = 0; j < kColumns; ++j) out.slope[j] += n.D[i][j] * Wc[i];
    }
    for (int r = 0; r < kColumns; r += 4)
      multiply<4, kColumns, Start::at_out>(&n.D[0][r], 1, kColumns, &WD[0][0], kColumns, kNdx,
                                           out.curvature[r], kColumns);
  }
}

}  // namespace sanso::mpc::SANSO_ISA
