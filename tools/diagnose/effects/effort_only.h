// Terms of an effort that the library does not have: they are found, and not simulated.
#pragma once

#include <string_view>

#include "tools/diagnose/effects/effect.h"

namespace sanso::diagnose {

/// What such a term is called; fields as in Effect.
struct EffortOnly {
  const char* id = "";    // stable
  const char* name = "";  // in words
  Family family{};
};

inline constexpr EffortOnly kEffortOffset{
    .id = "effort_offset", .name = "a constant effort", .family = Family::sensor};
inline constexpr EffortOnly kCoupledDrive{
    .id = "coupled_drive", .name = "a motor that turns two joints", .family = Family::transmission};

/// nullptr: no term of this id is outside the library.
inline const EffortOnly* find_effort_only(std::string_view id) {
  for (const EffortOnly* term : {&kEffortOffset, &kCoupledDrive}) {
    if (term->id == id) return term;
  }
  return nullptr;
}

}  // namespace sanso::diagnose
