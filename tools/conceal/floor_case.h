// Cases of the whole robot on a floor: what is hidden, how large, and the recordings of it.
#pragma once

#include "tools/conceal/conceal.h"
#include "tools/conceal/floor_world.h"

namespace sanso::conceal {

inline constexpr const char* kFloorRobot = "op3-floor";

/// A case of `op3-floor`, before it is written: robot.urdf, model.toml, recordings, answer.
struct FloorCase {
  std::string urdf, toml, answer;
  std::vector<recording::Recording> recordings;
};
/// Deterministic. Throws plant::WorldError for a family or effect that this robot cannot have.
FloorCase make_floor_case(const ConcealOptions& options);

}  // namespace sanso::conceal
