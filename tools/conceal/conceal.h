// Makes a case for the diagnosis: recordings of a hidden world, a nominal model folder, and the
// sealed answer.
//
//   DIR/model/robot.urdf, DIR/model/model.toml, DIR/recordings/rec_N.csv (+ .toml),
//   DIR/answer.sealed
//
// Neither seed nor family is written anywhere in the clear.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/conceal/hideable.h"

namespace sanso::conceal {

enum class Family { clean, single, pair, decoy, outside, ambiguous };
const char* to_string(Family family);
std::optional<Family> family_from_string(const std::string& name);

struct ConcealOptions {
  std::uint64_t seed = 1;
  std::string robot = "pendulum";  // "pendulum" | "arm" | "op3-stand"
  std::string out;                 // directory; made, must not hold a case already
  std::optional<Family> family;    // drawn when not given
  // target severity; drawn from 0.3, 1, 3, 10, 30 when not given
  std::optional<double> ratio;
  std::optional<std::string> effect;  // for single: which; drawn when not given
};

struct Concealed {
  std::string hash;                     // of answer.sealed
  std::string model;                    // folder
  std::vector<std::string> recordings;  // files
};

/// Deterministic: the same options give the same bytes. Throws plant::WorldError or
/// files::InputError.
Concealed conceal(const ConcealOptions& options);

}  // namespace sanso::conceal
