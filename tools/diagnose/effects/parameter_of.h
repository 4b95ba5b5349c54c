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

}  // namespace sanso::diagnose
