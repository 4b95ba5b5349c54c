// The model the upper layer plans with: x' = f_A(x, u, theta) ⊕ f_NN(x, u), and sigma F(x, u) w on top (host/mpc).
#pragma once

#include <optional>

#include "host/model/residual_network.h"

namespace sanso::host {

struct AugmentedModel {
  std::optional<ResidualNetwork> residual;  // empty until the first learning of the model, or switched off
};

}  // namespace sanso::host
