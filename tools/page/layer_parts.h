// What the live page and the replay show of one tick, alike.
#pragma once

#include <array>
#include <cmath>

#include "shared/wire/messages.h"

namespace sanso::page {

/// Numbers of a state that are shown: base position, quaternion, joint angles.
inline constexpr std::size_t kShown = 19;

/// What upper, middle and lower layer each add and take away: root mean square over the joints,
/// rad. The lower layer's is beyond `rest`, the pose that is held anyway.
inline std::array<double, 3> layer_parts(const wire::Observation& o, const model::Input& rest) {
  const auto rms = [](const model::Input& u) {
    return u.norm() / std::sqrt(double{model::kNumJoints});
  };
  return {rms(o.u_upper), rms(o.u_middle), rms(o.u_lower - rest)};
}

}  // namespace sanso::page
