// Cases of the whole robot on a floor: what is hidden, how large, and the recordings of it.
#pragma once

#include <nlohmann/json.hpp>

#include "tools/conceal/conceal.h"
#include "tools/conceal/floor_world.h"

namespace sanso::conceal {

inline constexpr const char* kFloorRobot = "op3-floor";

/// A case of `op3-floor`, before it is written: robot.urdf, model.toml, recordings, answer.
struct FloorCase {
  std::string urdf, toml, answer;
  std::vector<recording::Recording> recordings;
};

/// What a case will be, before anything is simulated.
struct FloorPlan {
  FloorTruth truth;
  std::vector<FloorMotion> motions;
  std::vector<std::uint64_t> noise;  // seed by motion
  nlohmann::json answer;             // of a decoy but for its defect
  Random random;                     // where the draw stands
};
/// Deterministic. `draw`: another case of the same seed. Throws plant::WorldError for a family or
/// effect that this robot cannot have.
FloorPlan plan_floor_case(const ConcealOptions& options, std::uint64_t draw = 0);
/// The first draw in which the robot stays on its feet in half of its motions. Throws as
/// plan_floor_case, and where none of many is one.
FloorCase make_floor_case(const ConcealOptions& options);
/// The model that is handed out: nominal, whatever is hidden.
std::string floor_toml(const FloorTruth& nominal);

}  // namespace sanso::conceal
