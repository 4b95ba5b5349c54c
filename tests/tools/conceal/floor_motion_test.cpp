// What the robot on a floor is asked to do can be done on two soles: they stay flat, a leg is up
// only while the other one carries, and nothing jumps.
#include "tools/conceal/floor_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tools/conceal/floor_world.h"

namespace sanso::conceal {
namespace {

FloorMotion walk() {
  FloorMotion m;
  m.name = "rec", m.condition = "walk", m.sway = 0.1, m.lift = 0.25, m.stride = 0.05;
  m.rate_hz = 0.5;
  return m;
}

std::vector<FloorMotion> some_motions() {
  FloorMotion squat, sway, one_leg = walk();
  squat.squat = 0.3, sway.sway = 0.1, one_leg.stride = 0.0, one_leg.rate_hz = 0.15;
  return {FloorMotion{}, squat, sway, one_leg, walk()};
}

/// Goals by joint, signs as of axes that point forward and to the left.
std::map<std::string, double> goals(const FloorMotion& m, double t) {
  std::map<std::string, double> out;
  for (const LinkSpec& l : nominal_floor().legs.links) {
    const double sign = l.axis[0] + l.axis[1] + l.axis[2] > 0 ? 1 : -1;
    out[l.joint] = sign * goal_of(l, m, t);
  }
  return out;
}

TEST(FloorMotion, KeepsTheSolesParallelToTheTrunk) {
  for (const FloorMotion& m : some_motions()) {
    for (double t = 0.0; t < 8.0; t += 0.13) {
      const auto g = goals(m, t);
      for (const char* side : {"l_", "r_"}) {
        const std::string s = side;
        EXPECT_NEAR(g.at(s + "hip_pitch") + g.at(s + "knee") + g.at(s + "ank_pitch"), 0.0, 1e-12);
        EXPECT_NEAR(g.at(s + "hip_roll") + g.at(s + "ank_roll"), 0.0, 1e-12);
        EXPECT_EQ(g.at(s + "hip_yaw"), 0.0);
      }
    }
  }
}

// a step of a joint's goal would be a tenth of a radian and more; unloaded servos turn at 4.8 rad/s
TEST(FloorMotion, NeverAsksForMoreThanAServosSpeed) {
  constexpr double kRow_s = 0.01, kServo_rad_s = 4.8;
  for (const FloorMotion& m : some_motions()) {
    auto before = goals(m, 0.0);
    for (double t = kRow_s; t < 8.0; t += kRow_s) {
      const auto now = goals(m, t);
      for (const auto& [joint, goal] : now)
        EXPECT_LT(std::abs(goal - before.at(joint)) / kRow_s, kServo_rad_s) << joint << " at " << t;
      before = now;
    }
  }
}

double force(const recording::Recording& r, const char* link, std::size_t row) {
  return r.find(std::string("fz:") + link)[row];
}

TEST(FloorMotion, ALegIsUpWhileTheOtherCarries) {
  const recording::Recording r = run_on_floor(nominal_floor(), walk(), 1);
  ASSERT_GT(r.rows(), 1100u) << "it fell";
  int left = 0, right = 0;
  for (std::size_t k = 0; k < r.rows(); ++k) {
    const double l = force(r, "l_ank_roll_link", k), a = force(r, "r_ank_roll_link", k);
    left += l < 2.0, right += a < 2.0;
    EXPECT_GT(l + a, 5.0) << "it flies at row " << k;
  }
  const int rows = static_cast<int>(r.rows());
  EXPECT_GT(left, rows / 10);
  EXPECT_GT(right, rows / 10);
  EXPECT_LT(left, rows / 2);
  EXPECT_LT(right, rows / 2);
}

TEST(FloorMotion, WalkingGoesSomewhereAndStandingDoesNot) {
  const auto way = [](const FloorMotion& m) {
    const recording::Recording r = run_on_floor(nominal_floor(), m, 2);
    const auto x = r.find("base_p:x"), y = r.find("base_p:y");
    return std::hypot(x.back() - x.front(), y.back() - y.front());
  };
  EXPECT_GT(way(walk()), 0.1);
  EXPECT_LT(way(FloorMotion{}), 0.005);
}

}  // namespace
}  // namespace sanso::conceal
