// From the furthest position in all recordings, in the direction of `side`.
#include "tools/diagnose/verdict/yielding.h"

#include <algorithm>

#include "tools/diagnose/effects/effect.h"

namespace sanso::diagnose {
namespace {

/// Of the first parameter that `is` says it is; null: none.
const double* value_of(const Candidate& candidate, const std::vector<double>& theta, auto&& is) {
  for (std::size_t i = 0; i < candidate.parameters.size(); ++i)
    if (is(candidate.parameters[i])) return &theta[i];
  return nullptr;
}

}  // namespace

double gone_beyond(const Comparison& comparison, const Candidate& candidate,
                   const std::vector<double>& theta) {
  const double* position =
      value_of(candidate, theta, [](const auto& p) { return p.role == Role::position; });
  const double* side = value_of(candidate, theta, [](const auto& p) { return p.name == "side"; });
  if (position == nullptr) return 0.0;
  const double sign = side != nullptr && *side < 0.0 ? -1.0 : 1.0;
  double furthest = 0.0;
  for (const Source& source : comparison.sources) {
    for (const std::size_t joint : candidate.joints) {
      for (const double q : source.motion.q[joint])
        furthest = std::max(furthest, sign * (q - *position));
    }
  }
  return furthest;
}

std::vector<std::string_view> yields_like(const Comparison& comparison, const Candidate& candidate,
                                          const std::vector<double>& theta) {
  const Effect* effect = find_effect(candidate.effect);
  if (effect == nullptr || effect->yielding.empty()) return {};
  const double gives = comparison.settings.decisions.stop_gives;
  return gone_beyond(comparison, candidate, theta) > gives ? effect->yielding
                                                           : std::vector<std::string_view>{};
}

}  // namespace sanso::diagnose
