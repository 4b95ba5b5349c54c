// The velocity channel against the motion of the position channel.
#include "tools/diagnose/verdict/velocity.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/small_world.h"
#include "tools/diagnose/stats/random.h"
#include "tools/diagnose/verdict/predictability.h"

namespace sanso::diagnose {
namespace {

constexpr const char* kServo = "actuator = \"dc_servo\"\np_gain = 4.0\narmature = 0.01\n";
constexpr double kNoise = 0.01;  // rad/s

/// Twenty seconds of two sines; the velocity is read through `sensor(true velocity, true
/// acceleration)`.
template <class Sensor>
Predictability judged(const Sensor& sensor) {
  Random random(3);
  recording::Recording r;
  r.file = "made.csv";
  std::vector<double> q, dq;
  for (int k = 0; k <= 2000; ++k) {
    const double t = 0.01 * k;
    r.t.push_back(t);
    q.push_back(0.6 * std::sin(2 * t) + 0.2 * std::sin(7 * t) + 3e-4 * random.normal());
    const double v = 1.2 * std::cos(2 * t) + 1.4 * std::cos(7 * t),
                 a = -2.4 * std::sin(2 * t) - 9.8 * std::sin(7 * t);
    dq.push_back(sensor(v, a) + kNoise * random.normal());
  }
  r.set("u:a", q);
  r.set("q:a", q);
  r.set("dq:a", dq);
  const std::vector<NoiseLevel> noise{{"q:a", 0.0, 3e-4, {}}, {"dq:a", 0.0, kNoise, {}}};
  const std::vector<Source> sources = make_sources(test::pendulum(kServo), {r}, noise, Settings{});
  return predictability(velocity_errors(sources, noise, Settings{}), 0, Random(1), Settings{});
}

TEST(VelocityChannel, OffsetAndGainErrorOfASensorAreNoMismatch) {
  for (const double gain : {0.96, 1.0, 1.04}) {
    const Predictability p = judged([gain](double v, double) { return 0.02 + gain * v; });
    EXPECT_LT(p.torque_rms, 1.3 * p.noise_rms) << gain;
    EXPECT_LT(p.explained, 0.1) << gain;
  }
}

TEST(VelocityChannel, ALateReadingFollowsTheAcceleration) {
  const Predictability p = judged([](double v, double a) { return v - 0.01 * a; });
  EXPECT_GT(p.explained, 0.8);
  EXPECT_LT(p.p, 0.01);
  EXPECT_GT(p.torque_rms, 2.0 * p.noise_rms);
}

/// A gain error beyond what a sensor may have stays.
TEST(VelocityChannel, AGainFarOffIsAMismatch) {
  const Predictability p = judged([](double v, double) { return 1.2 * v; });
  EXPECT_GT(p.explained, 0.8);
  EXPECT_GT(p.torque_rms, 2.0 * p.noise_rms);
}

}  // namespace
}  // namespace sanso::diagnose
