// Do recordings agree about a size? One number for all of them is a claim of its own: a payload
// that was on in one condition has no size that holds for both.
#pragma once

#include <string>
#include <vector>

#include "tools/diagnose/settings.h"

namespace sanso::diagnose {

/// A size as one recording, or one condition, alone tells it.
struct GroupValue {
  std::string group;
  double value = 0.0, sigma = 0.0;  // standard deviation
};

/// "recordings disagree about coulomb_friction.coulomb at a: 0.2 [0.18, 0.22] N m in rec_1; ...";
/// empty: they agree, or fewer than two tell it. They disagree where one is twice as far from the
/// mean of the others as chance lets a size count, and by a quarter of its own size.
std::string disagreement(const std::string& what, const std::string& unit,
                         const std::vector<GroupValue>& values, const DecisionSettings& decisions);

}  // namespace sanso::diagnose
