// Knot by knot: forget by mu, add alpha times what the upper layer did, with its gain limited in
// norm.
#include "host/learn/layers/middle_layer.h"

#include <algorithm>
#include <cassert>

namespace sanso::learn {

using model::minus;
using model::plus;
using model::State;
using model::Tangent;

model::Gain limited_gain(const model::Gain& K, double max_norm) {
  const double norm = K.norm();
  return norm > max_norm ? model::Gain(K * (max_norm / norm)) : K;
}

void start_middle_layer(const std::vector<State>& reference, const MiddleLayerSettings& settings,
                        policy::MiddleTable& table) {
  table.knots.clear();
  for (const State& x : reference) {
    policy::Knot knot;
    knot.x = settings.start_at_reference ? x : reference.front();
    // longer motions hold the last knot; the motion loader refuses them before
    if (!table.knots.try_push(knot)) break;
  }
}

void update_middle_layer(const std::vector<UpperSample>& upper, const std::vector<State>& x_init,
                         bool failed, const MiddleLayerSettings& settings,
                         policy::MiddleTable& table) {
  assert(x_init.size() >= table.knots.size());
  const double mu = settings.forgetting_rate;
  for (std::size_t i = 0; i < table.knots.size(); ++i) {
    policy::Knot& middle = table.knots[i];
    const bool learn = !failed && i < upper.size();
    const double alpha = learn ? settings.learning_rate * upper[i].weight : 0.0;
    const policy::Knot star = learn ? upper[i].knot : middle;

    middle.u += alpha * star.u - mu * middle.u;
    middle.K += settings.gain_rate_factor * alpha * limited_gain(star.K, settings.max_gain_norm) -
                mu * middle.K;
    // x_mid ⊕ (alpha (x_up ⊖ x_mid) - mu (x_mid ⊖ x_init)), both differences in the tangent at
    // x_mid
    const Tangent towards_upper = minus(star.x, middle.x);
    const Tangent towards_start = minus(x_init[i], middle.x);
    middle.x = plus(middle.x, alpha * towards_upper + mu * towards_start);
  }
}

}  // namespace sanso::learn
