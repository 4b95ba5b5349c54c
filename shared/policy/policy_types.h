// What the upper and the middle layer hand to the low-level controller, and how it is sampled in
// time.
// u = u_up + K_up (x ⊖ x_up) + u_mid + K_mid (x ⊖ x_mid) + u_low   (paper, eq. "u act").
#pragma once

#include <array>
#include <cstdint>

#include "shared/base/fixed_vector.h"
#include "shared/base/time.h"
#include "shared/model/state_layout.h"

namespace sanso::policy {

/// One knot of an affine policy: u + K (x ⊖ x_ref).
struct Knot {
  model::Input u = model::Input::Zero();    // rad
  model::State x = model::neutral_state();  // the state at which u alone is right
  model::Gain K = model::Gain::Zero();      // rad per tangent unit
};

/// Upper-layer policy. Knot i is valid at tick `first_tick + i * ticks_per_knot` of the running
/// trial; first-order hold between.
inline constexpr std::size_t kMaxUpperKnots = 4;
struct UpperPolicy {
  // counts up within a trial; older than the one in use: dropped
  std::uint32_t sequence = 0;
  std::uint32_t trial_id = 0;
  std::int32_t first_tick = 0;  // tick of the trial (10 ms) at which knot 0 holds
  std::int32_t ticks_per_knot = kTicksPerUpper;
  FixedVector<Knot, kMaxUpperKnots> knots;
};

/// Middle-layer table: knot i at tick i * kTicksPerMiddle of the trial; first-order hold, held at
/// the ends.
inline constexpr std::size_t kMaxMiddleKnots = 500;  // 15 s of 30 ms
struct MiddleTable {
  std::uint32_t trial_id = 0;
  FixedVector<Knot, kMaxMiddleKnots> knots;
};

/// Which layers add to the sum during a trial, for ablations. The wire carries mask().
struct LayerSwitches {
  static constexpr std::uint8_t kLower = 1, kMiddle = 2, kUpper = 4, kReflex = 8, kAll = 15;

  bool lower = true, middle = true, upper = true, reflex = true;

  static constexpr LayerSwitches from_mask(unsigned mask) {
    return {(mask & kLower) != 0, (mask & kMiddle) != 0, (mask & kUpper) != 0,
            (mask & kReflex) != 0};
  }
  constexpr std::uint8_t mask() const {
    return static_cast<std::uint8_t>((lower ? kLower : 0) | (middle ? kMiddle : 0) |
                                     (upper ? kUpper : 0) | (reflex ? kReflex : 0));
  }
};

}  // namespace sanso::policy
