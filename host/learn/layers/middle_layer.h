// The middle layer: a long-latency response learned over trials to do what the upper layer did
// (paper, eqs. "u middle learn" and "x middle learn"), on the 30 ms grid.
#pragma once

#include <vector>

#include "shared/policy/policy_types.h"

namespace sanso::learn {

struct MiddleLayerSettings {
  double learning_rate = 0.05;
  double gain_rate_factor = 0.3;
  double forgetting_rate = 0.01;
  double max_gain_norm = 13.0;
  bool start_at_reference = true;
  bool first_knots_follow = true;

  constexpr void visit(auto&& field) {
    field("learning_rate", learning_rate, "1", 0.0, 1.0,
          "alpha (paper: 0.05); 0 after a failed trial");
    field("gain_rate_factor", gain_rate_factor, "1", 0.0, 1.0,
          "share of alpha for K: quieter targets at the same cost (measured); paper: 1");
    field("forgetting_rate", forgetting_rate, "1", 0.0, 0.5,
          "mu (paper: 0.01); fixed point u_mid = (alpha / mu) u_up = 5 u_up");
    field("max_gain_norm", max_gain_norm, "rad", 0.0, 1000.0,
          "Frobenius norm: spikes of K_up above it would be learned and stay; 1000: none (paper)");
    field(
        "start_at_reference", start_at_reference, "yes or no", false, true,
        "x_mid starts at the reference, so that K_mid pulls to it; no: at the first state (paper)");
    field("first_knots_follow", first_knots_follow, "yes or no", false, true,
          "knots before the first plan learn its first knot: the robot holds by them; no: nothing");
  }
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
