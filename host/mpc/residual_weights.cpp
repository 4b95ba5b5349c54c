// Done once for each new network, outside planning, so that the kernels need no standardisation.
#include "host/mpc/residual_weights.h"

#include <cstring>

#include "host/model/residual_network.h"

namespace sanso::mpc {

static_assert(kFeatureCount == host::kFeatures && kHiddenUnits == host::kHidden &&
              kOutputCount == model::kNdx);

void fold(const host::ResidualNetwork& n, ResidualWeights& out) {
  std::memset(static_cast<void*>(&out), 0, sizeof out);
  out.present = true;
  for (int unit = 0; unit < kHiddenUnits; ++unit) {
    double bias = static_cast<double>(n.b1[unit]);
    for (int i = 0; i < kFeatureCount; ++i) {
      const float w = n.W1(unit, i) * n.feature_scale[i];
      out.W1[i][unit] = out.W1_by_unit[unit][i] = w;
      bias -= static_cast<double>(w) * static_cast<double>(n.feature_mean[i]);
    }
    out.b1[unit] = static_cast<float>(bias);
    out.b2[unit] = n.b2[unit];
    for (int below = 0; below < kHiddenUnits; ++below)
      out.W2[below][unit] = out.W2_by_unit[unit][below] = n.W2(unit, below);
    for (int i = 0; i < kOutputCount; ++i) out.W3[unit][i] = n.W3(i, unit) * n.output_scale[i];
  }
  for (int i = 0; i < kOutputCount; ++i) out.b3[i] = n.b3[i] * n.output_scale[i] + n.output_mean[i];
}

}  // namespace sanso::mpc
