// The model the upper layer plans with: x' = f_A(x, u, theta) ⊕ f_NN(x, u), and sigma F(x, u) w on
// top (host/mpc).
#pragma once

#include <optional>
#include <vector>

#include "host/model/residual_network.h"
#include "shared/model/ground.h"
#include "shared/model/step_model.h"

namespace sanso::host {

struct AugmentedModel {
  model::StepModel analytical = model::make_step_model(model::nominal_parameters());
  model::Ground ground = model::make_plane();
  // implicit steps within one model step; chosen in docs/results
  int substeps = 1;
  // step length the residual was trained on; shorter steps take their share
  double residual_dt_s = 0.06;
  // empty until the first learning of the model, or switched off
  std::optional<ResidualNetwork> residual;
  // analytical models that fit the data about as well; empty: nobody asked
  std::vector<model::StepModel> spread;
};

}  // namespace sanso::host
