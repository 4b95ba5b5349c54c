// What the page draws: the robot and its ground as the emulated robot's own model says them.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "tools/plant/world.h"

namespace sanso::page {

/// {"mjcf": text, "fixed": {joint: rad} of arms and head, "joints": names in the model's order}.
nlohmann::json scene_of(const plant::World& world);

}  // namespace sanso::page
