// What a robot shows by moving from pose to pose, before any trial: standing tells nothing of the
// servos' damping (static_balance.h), the ways between the poses do. Friction and the delays of a
// real drive, which the model has not, are in it: to joints that follow their targets both are a
// lag.
#pragma once

#include <functional>
#include <vector>

#include "host/learn/model/parameter_map.h"
#include "host/learn/model/prediction.h"

namespace sanso::learn {

struct DampingOfMovesSettings {
  double moving_rad = 0.06;
  double lowest_damping = -1.0;
  double highest_damping = 1.35;

  constexpr void visit(auto&& field) {
    field("moving_rad", moving_rad, "rad", 0.0, 3.0,
          "0.72 s in which no target moves so far tell of friction at rest, not of damping");
    field("lowest_damping", lowest_damping, "prior deviations", -10.0, 0.0,
          "that the moves may give: 0.78 times the initial model's");
    field(
        "highest_damping", highest_damping, "prior deviations", 0.0, 10.0,
        "1.4 times, what walking shows in the easy world: on ways as short dry friction looks like "
        "any amount of damping");
  }
};

/// The windows in which some joint's target moves by `least_rad` or more.
std::vector<PredictionWindow> moves_of(std::vector<PredictionWindow> windows, double least_rad);

/// The entry "damping" of z, in prior deviations, with which `loss` of a z is least between the
/// settings' bounds; all other entries stay. Golden section: `loss` has one minimum there.
double best_damping(const ParameterMap& map, Eigen::VectorXd z,
                    const std::function<double(const Eigen::VectorXd&)>& loss,
                    const DampingOfMovesSettings& settings);

/// Where "damping" stands in the map's z.
Eigen::Index damping_entry(const ParameterMap& map);

}  // namespace sanso::learn
