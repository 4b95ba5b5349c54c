// What a joint is doing at a row: the regimes of the location map (method 3.5). A row can be in
// several.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/compare/problem.h"

namespace sanso::diagnose {

struct Regimes {
  std::vector<std::string> names;
  std::vector<std::vector<std::vector<std::vector<char>>>> mask;  // [source][joint][regime][row]
  bool in(std::size_t source, std::size_t joint, std::size_t regime, std::size_t row) const {
    return mask[source][joint][regime][row] != 0;
  }
};

/// Regimes of every row from the smoothed motion, the commands and the torques that the nominal
/// model replays.
Regimes find_regimes(const Comparison& comparison);

}  // namespace sanso::diagnose
