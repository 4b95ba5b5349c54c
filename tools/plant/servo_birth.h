// What a servo is born with and keeps: where its horn sits, and the gain of its own position loop.
#pragma once

#include <algorithm>
#include <cstdint>

#include "tools/plant/random.h"
#include "tools/plant/world.h"

namespace sanso::plant {

struct ServoBirth {
  double zero_offset_rad = 0.0;  // it reports its joint's angle plus this
  double gain_scale = 1.0;       // of its position loop
};

/// Of servo `id`, 1 to 20: one world gives it the same birth always. Even ids are the left side's.
inline ServoBirth birth_of(const ServoParameters& s, int id) {
  Random random(s.spread_seed * 64 + static_cast<std::uint64_t>(id) + 0xB1247u);
  ServoBirth birth;
  birth.zero_offset_rad = s.zero_offset_rad * random.normal();
  birth.gain_scale = std::max(0.2, 1.0 + s.gain_spread * random.normal());
  if (id % 2 == 0) birth.gain_scale *= s.left_gain_scale;
  return birth;
}

}  // namespace sanso::plant
