// A stop that gives way may be something else that begins to pull there.
#pragma once

#include <string_view>
#include <vector>

#include "tools/diagnose/fit/fit.h"

namespace sanso::diagnose {

/// How far the recordings go beyond the `position` of an effect, towards its `side` [rad; m]: the
/// furthest of its joints. 0: nowhere, or the effect begins at no position.
double gone_beyond(const Comparison& comparison, const Candidate& candidate,
                   const std::vector<double>& theta);

/// Effects that the candidate may be, because its joint goes further beyond its position than
/// DecisionSettings::stop_gives; empty: it does not.
std::vector<std::string_view> yields_like(const Comparison& comparison, const Candidate& candidate,
                                          const std::vector<double>& theta);

}  // namespace sanso::diagnose
