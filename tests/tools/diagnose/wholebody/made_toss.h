// A ball that is thrown onto a table, by textbook formulas.
#pragma once

#include "tests/tools/diagnose/wholebody/made_body.h"

namespace sanso::diagnose::test {

struct World {
  double scale = 1.0;  // recorded positions over true ones
  double clock = 1.0;  // recorded seconds over true ones
  double restitution = 0.4, friction = 0.2;
  double noise = 2e-5;  // m
};

inline constexpr double kRadius = 0.05, kMass = 0.5, kInertia = 5e-4, kG = 9.81, kStep = 0.004;

struct Ball {
  V3 p, v, w = V3::Zero();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();

  void fly(double dt) {
    p += v * dt + V3(0, 0, -0.5 * kG * dt * dt), v += V3(0, 0, -kG * dt);
    const double turn = w.norm() * dt;
    if (turn > 0.0) q = Eigen::Quaterniond(Eigen::AngleAxisd(turn, w.normalized())) * q;
  }
  void hit(const World& world) {
    const V3 arm(0, 0, -kRadius);
    const double into = -v.z();
    V3 slip = v + w.cross(arm);
    slip.z() = 0.0;
    V3 impulse(0, 0, kMass * (1.0 + world.restitution) * into);
    const double sticks = slip.norm() / (1.0 / kMass + kRadius * kRadius / kInertia);
    if (slip.norm() > 0.0)
      impulse -= slip.normalized() * std::min(world.friction * impulse.z(), sticks);
    v += impulse / kMass, w += arm.cross(impulse) / kInertia;
  }
};

/// Rows of a flight of `rest` seconds after which the ball hits, and so on until it lies.
inline recording::Recording toss(const World& world, unsigned long seed) {
  Random random(seed);
  Ball ball{{0, 0, 0.25 + 0.1 * random.uniform()},
            {4.0 + 2.0 * random.uniform(), 0.5 * random.normal(), 0.3 * random.normal()}};
  recording::Recording r;
  r.file = "toss_" + std::to_string(seed) + ".csv";
  std::vector<V3> p, v, w;
  std::vector<Eigen::Quaterniond> q;
  const auto write = [&](double t) {
    r.t.push_back(t * world.clock);
    const V3 noise(random.normal(), random.normal(), random.normal());
    p.push_back(world.scale * ball.p + world.noise * noise);
    v.push_back(world.scale / world.clock * ball.v);
    w.push_back(ball.q.conjugate() * ball.w / world.clock), q.push_back(ball.q);
  };
  for (double t = 0.0; t < 1.6; t += kStep) {
    write(t);
    double left = kStep;
    // falls to the table inside this step, perhaps more than once
    for (int hits = 0; hits < 20; ++hits) {
      const double drop = ball.p.z() - kRadius;
      const double until =
          (ball.v.z() + std::sqrt(std::max(0.0, ball.v.z() * ball.v.z() + 2 * kG * drop))) / kG;
      if (until > left) break;
      ball.fly(until), left -= until;
      ball.p.z() = kRadius, ball.hit(world);
      if (ball.v.z() < 0.02) ball.v = V3::Zero(), ball.w = V3::Zero();
    }
    if (ball.v.norm() > 0.0 || ball.p.z() > kRadius + 1e-9) ball.fly(left);
  }
  put(r, "base_p", "xyz", [&](auto k, auto i) { return p[k][static_cast<long>(i)]; });
  put(r, "base_q", "wxyz", [&](auto k, auto i) { return part_of(q[k], i); });
  put(r, "base_v", "xyz", [&](auto k, auto i) { return v[k][static_cast<long>(i)]; });
  put(r, "base_w", "xyz", [&](auto k, auto i) { return w[k][static_cast<long>(i)]; });
  return r;
}

}  // namespace sanso::diagnose::test
