// The middle layer: a long-latency response learned over trials to do what the upper layer did
// (paper, eqs. "u middle learn" and "x middle learn"), on the 30 ms grid.
#pragma once

#include <vector>

#include "shared/policy/policy_types.h"

namespace sanso::learn {

struct MiddleLayerSettings {
  double learning_rate = 0.05;  // alpha; taken as 0 after a failed trial (paper)
  // K is learned at this share of alpha: quieter targets at the same cost (measured)
  double gain_rate_factor = 0.3;
  double forgetting_rate = 0.01;   // mu; fixed point u_mid = (alpha/mu) u_up = 5 u_up
  double max_gain_norm = 13.0;     // Frobenius; spikes of K_up above it would be learned and stay
  bool start_at_reference = true;  // false: x_mid starts at the constant first state (paper)
};

/// What the upper layer did at one knot of the middle layer's grid.
struct UpperSample {
  policy::Knot knot;    // u_up, x_up, K_up at that time, first-order hold of the executed policy
  double weight = 0.0;  // the controller's fade: 1 in full use, 0 when there was no policy
};

/// Scales K down to `max_norm` (Frobenius) when it is larger; direction kept.
model::Gain limited_gain(const model::Gain& K, double max_norm);

/// The table of trial 0: u and K zero, x from `reference` (one state a knot).
void start_middle_layer(const std::vector<model::State>& reference,
                        const MiddleLayerSettings& settings, policy::MiddleTable& table);

/// One learning step after a trial. `x_init[i]` is what knot i's x started from; `upper[i]` belongs
/// to knot i, and may be shorter than the table when the trial ended early (those knots only
/// forget).
void update_middle_layer(const std::vector<UpperSample>& upper,
                         const std::vector<model::State>& x_init, bool failed,
                         const MiddleLayerSettings& settings, policy::MiddleTable& table);

}  // namespace sanso::learn
