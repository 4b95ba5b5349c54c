// What of the data stays without a name, and how that shows.
#pragma once

#include <optional>
#include <string>

#include "tools/diagnose/verdict/evidence.h"

namespace sanso::diagnose {

/// Where what has no name shows: the missing torque, the velocity channel against the position
/// channel, short stretches, or no more than the level of the position error.
enum class ShowsIn { torque, velocity_channel, stretches, position };
const char* to_string(ShowsIn where);

struct Unexplained {
  ShowsIn shows_in = ShowsIn::position;
  // cross-validated share of it that joint state predicts (torque, velocity channel)
  double predictable = 0.0;
  double p = 1.0;
  // of the original prediction error beyond noise, still there after the patch
  double energy_share = 0.0;
  std::string where, regime;
  std::string formula;  // sparse regression's answer: a description of the shape, not a name
  std::string nearest_effect;
};

/// Nothing: what is left is noise, and every name that was found is confirmed or one of a set.
std::optional<Unexplained> unexplained(const Evidence& evidence);

/// The joint whose remaining error is most surely physics: predictable, and larger than noise makes
/// it; nullptr: none.
const Predictability* most_predictable(const std::vector<Predictability>& left,
                                       const DecisionSettings& decisions);

}  // namespace sanso::diagnose
