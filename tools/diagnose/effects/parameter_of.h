// What the library says of a parameter that was found under its name.
#pragma once

#include <string_view>

#include "tools/diagnose/effects/effect.h"

namespace sanso::diagnose {

/// nullptr: the library has no such effect, or the effect no such parameter.
inline const EffectParameter* find_parameter(std::string_view effect, std::string_view name) {
  const Effect* found = find_effect(effect);
  if (found == nullptr) return nullptr;
  for (const EffectParameter& p : found->parameters) {
    if (p.name == name) return &p;
  }
  return nullptr;
}

/// A limit that acts. A fit that begins off its bound leaves one that does not a hair below kOff.
inline bool is_on(double limit) { return limit < 0.5 * kOff; }

/// A limit that was found to be off.
inline bool is_off(std::string_view effect, std::string_view name, double value) {
  const EffectParameter* known = find_parameter(effect, name);
  return known != nullptr && known->null == kOff && !is_on(value);
}

}  // namespace sanso::diagnose
