// What can be hidden in a robot on a floor: effects of the library, and mechanisms that no library
// has.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/conceal/floor_world.h"

namespace sanso::conceal {

struct FloorEffect {
  std::string id;
  double smallest;  // size at ratio 1: about what a tolerance or its estimate's noise is
  bool in_library;
  /// Hides a size; tells the parameters by the library's names, and `where` the places.
  std::function<nlohmann::json(FloorTruth&, double size, Random&, std::vector<std::string>& where)>
      apply;
};

const std::vector<FloorEffect>& floor_effects();

}  // namespace sanso::conceal
