// What can be hidden: the effects of the diagnosis's library that a fixed-base world can show (by
// their ids and parameter names, docs/model-folder.md), and some physics that the library has no
// name for.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/conceal/hidden_world.h"

namespace sanso::conceal {

/// An effect as it was hidden. Parameters by the library's names and units.
struct HiddenEffect {
  std::string id;
  std::vector<std::string> where;  // joints, a link, or nothing for the whole robot
  std::map<std::string, double> parameters;
  // N m of dry friction that it could not do without, beyond its own: in the world too, so naming
  // it is no mistake
  double coulomb_beside = 0.0;
};

struct Hideable {
  std::string id;
  enum class Scope { joint, link, robot } scope;
  double typical, largest;  // of the size that severity scales
  bool in_library;
  /// Draws the other parameters, applies the effect of this size to joint or link `at`, and tells
  /// what it did.
  std::function<HiddenEffect(WorldTruth& world, int at, double size, Random& random)> apply;
  /// Confounders that data without electrical channels and without a second gain cannot tell apart;
  /// empty: none known.
  std::vector<std::string> twins;
};

const std::vector<Hideable>& hideables();
/// Throws plant::WorldError when there is none of this id.
const Hideable& hideable(const std::string& id);

}  // namespace sanso::conceal
