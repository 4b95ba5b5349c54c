// Random states of the OP3 for tests: near standing with contacts on and off, or anywhere.
#pragma once

#include <random>

#include "shared/model/op3_kinematics.h"

namespace sanso::model {

/// Tangent with the given spreads: metres, rad, rad, m/s, rad/s, rad/s.
inline Tangent random_tangent(std::mt19937& rng, double p, double theta, double q, double v,
                              double w, double dq) {
  std::normal_distribution<double> normal;
  Tangent d;
  for (int i = 0; i < kNdx; ++i) d[i] = normal(rng);
  d.segment<3>(kDPos) *= p;
  d.segment<3>(kDTheta) *= theta;
  d.segment<kNumJoints>(kDJoint) *= q;
  d.segment<3>(kDVel) *= v;
  d.segment<3>(kDOmega) *= w;
  d.segment<kNumJoints>(kDJointRate) *= dq;
  return d;
}

/// Around standing: tilted, moving, soles some centimetres above or inside the ground.
inline State state_near_standing(std::mt19937& rng) {
  return plus(standing_state(), random_tangent(rng, 0.02, 0.1, 0.2, 0.3, 0.5, 1.0));
}

/// Anything goes: upside down, folded legs, fast; high above the ground.
inline State state_in_the_air(std::mt19937& rng) {
  State x = plus(standing_state(), random_tangent(rng, 0.3, 1.0, 0.8, 1.0, 3.0, 5.0));
  x[kXPos + 2] += 5.0;
  return x;
}

/// x after `time` s with its velocities as they are.
inline State drifted(const State& x, double time) {
  Tangent way = Tangent::Zero();
  way.head<kNv>() = time * x.tail<kNv>();
  return plus(x, way);
}

inline Input random_input(std::mt19937& rng, const State& x) {
  std::normal_distribution<double> normal;
  Input u = joints(x);
  for (int j = 0; j < kNu; ++j) u[j] += 0.15 * normal(rng);
  return u;
}

}  // namespace sanso::model
