// How far the planner trusts the residual network, judged on trials that the network has not seen.
//
// A network is trained on trials of an older policy. The next model makes the planner move
// differently, and what was learned there may not hold here. So a new network first only watches.
// After every trial it is judged on that trial, which it has not seen, and gets the share of its
// correction that would have predicted it best: at most a quarter more than before, since with
// every step the planner follows it further; and a share that was too much is not tried again
// before the next training. (docs/decisions)
#pragma once

#include <vector>

#include "host/learn/model/prediction.h"

namespace sanso::learn {

inline constexpr double kShareStep = 0.25;
// a share counts only if the N-step loss falls below so much of that without
inline constexpr double kClearlyBetter = 0.95;
// 1.8 s of windows; shorter trials ended in a fall and judge nothing
inline constexpr std::size_t kFewestJudgedWindows = 30;

struct ResidualTrust {
  double share = 0.0;    // of the network's correction that the planner uses; 0: it only watches
  double ceiling = 1.0;  // the share may rise up to here
};

/// The same network with `share` of its correction: every output and derivative times share.
host::ResidualNetwork with_share(host::ResidualNetwork network, double share);

struct Share {
  double share = 0.0;  // of a network's correction; 0: none
  double loss = 0.0;   // N-step loss with it
};

/// The share, at most `highest`, with the lowest N-step loss on the windows; 0 when none is clearly
/// better than no network.
Share best_share(const std::vector<PredictionWindow>& windows, const model::StepModel& analytical,
                 const model::Ground& ground, const model::Tangent& weights,
                 const host::ResidualNetwork& network, double highest);

/// Trust after one more trial, which must be newer than the network's training. Too few windows:
/// unchanged.
ResidualTrust judged(const ResidualTrust& before, const std::vector<PredictionWindow>& windows,
                     const model::StepModel& analytical, const model::Ground& ground,
                     const model::Tangent& weights, const host::ResidualNetwork& network);

}  // namespace sanso::learn
