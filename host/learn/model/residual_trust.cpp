// Tries shares up to the highest one allowed and keeps the one of lowest loss; a share that had
// to fall is the ceiling from then on.
#include "host/learn/model/residual_trust.h"

#include <algorithm>

namespace sanso::learn {

host::ResidualNetwork with_share(host::ResidualNetwork network, double share) {
  network.output_mean *= static_cast<float>(share);
  network.output_scale *= static_cast<float>(share);
  return network;
}

Share best_share(const std::vector<PredictionWindow>& windows, const model::StepModel& analytical,
                 const model::Ground& ground, const model::Tangent& weights,
                 const host::ResidualNetwork& network, double highest) {
  Share best{0.0, n_step_loss(windows, analytical, ground, weights)};
  double clearly_better = kClearlyBetter * best.loss;
  for (int steps = 1; steps * kShareStep <= highest; ++steps) {
    const double share = steps * kShareStep;
    const host::ResidualNetwork scaled = with_share(network, share);
    const double loss = n_step_loss(windows, analytical, ground, weights, &scaled);
    if (!(loss < clearly_better)) continue;
    clearly_better = loss;
    best = {share, loss};
  }
  return best;
}

ResidualTrust judged(const ResidualTrust& before, const std::vector<PredictionWindow>& windows,
                     const model::StepModel& analytical, const model::Ground& ground,
                     const model::Tangent& weights, const host::ResidualNetwork& network) {
  if (windows.size() < kFewestJudgedWindows) return before;
  const double highest = std::min(before.ceiling, before.share + kShareStep);
  const double share = best_share(windows, analytical, ground, weights, network, highest).share;
  return {share, share < before.share ? share : before.ceiling};
}

}  // namespace sanso::learn
