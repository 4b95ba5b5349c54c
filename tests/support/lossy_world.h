// A servo that does not get all of its commands.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/small_comparison.h"
#include "tools/diagnose/stats/random.h"

namespace sanso::diagnose::test {

inline constexpr const char* kServo =
    "actuator = \"dc_servo\"\np_gain = 4.0\narmature = 0.01\ncoulomb = 0.02";
inline constexpr double kNoise = 4e-4;  // rad

/// Goal [rad] of recording `index` at t [s].
using Goal = double (*)(int index, double t);
inline double swing(int index, double t) {
  return 0.7 * std::sin((1.3 + 0.4 * index) * t) + 0.3 * std::sin((4.1 + 0.7 * index) * t);
}
/// From 3 to 6 s far more than the motor follows: at full duty one way and the other.
inline double swing_beyond_the_motor(int index, double t) {
  return swing(index, t) + (t > 3.0 && t < 6.0 ? 3.0 * std::sin(2.5 * t) : 0.0);
}

/// 10 s at 100 Hz of a servo in a world with `effects` that did not get the commands of `lost`.
inline recording::Recording record(const std::vector<EffectEntry>& effects, int index,
                                   const std::vector<std::size_t>& lost, double noise = kNoise,
                                   Goal goal = swing) {
  const ModelFolder world = hiding(pendulum(kServo), effects);
  const Drive sent =
      make_test_drive(world, 10.0, 0.01, [index, goal](int, double t) { return goal(index, t); });
  Drive received = sent;
  for (const std::size_t row : lost)
    received.joints[0].command[row] = received.joints[0].command[row - 1];
  recording::Recording r = test::record(
      world, received, {.file = "made_" + std::to_string(index) + ".csv", .duty = true});
  Random random(23, static_cast<std::uint64_t>(index));
  std::vector<double> q(r.find("q:a").begin(), r.find("q:a").end());
  for (double& x : q) x += noise * random.normal();
  r.set("q:a", q);
  r.set("u:a", sent.joints[0].command);
  return r;
}

}  // namespace sanso::diagnose::test
