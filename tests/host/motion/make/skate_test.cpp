// Motions on wheels: the wheels stay on the surface, the posture stays, energy pays for the speed,
// and the shipped files are what the command makes.
#include "host/motion/make/skate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "host/motion/make/body_kinematics.h"
#include "shared/grounds/ground_file.h"
#include "shared/model/foot_shape.h"
#include "shared/model/joints.h"

namespace sanso::motion {
namespace {

/// Of all wheels at x [m].
struct Clearance {
  double lowest = 1.0, highest = -1.0;
};

Clearance above_ground(const model::State& x, const model::Ground& ground) {
  Clearance clear;
  const BodyPoints points = body_points(x);
  for (const int side : {kRight, kLeft}) {
    for (const double along : {-1.0, 1.0}) {
      const math::Vec3 p = points.p_world_foot[side] +
                           points.R_world_foot[side] *
                               math::Vec3(model::kSoleCentreX + along * model::kSkates.half_length,
                                          0.0, model::kSkates.height);
      const double above = p.z() - ground_height(ground, p.x());
      clear.lowest = std::min(clear.lowest, above);
      clear.highest = std::max(clear.highest, above);
    }
  }
  return clear;
}

class SkateMotion : public ::testing::TestWithParam<std::string> {
 protected:
  Motion motion_ = MotionLibrary().load(GetParam());
  model::Ground ground_ = motion_.ground();
  std::vector<model::State> x_ = motion_.reference().x;
};

TEST_P(SkateMotion, FileIsWhatTheCommandMakes) {
  std::ifstream file(MotionLibrary().folder() / (GetParam() + ".toml"), std::ios::binary);
  const std::string shipped{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(to_toml(make_skate(GetParam()).motion), shipped);
  EXPECT_EQ(to_toml(parse_motion(shipped, GetParam())), shipped);
}

TEST_P(SkateMotion, StartsAtRestWhereTheProfileBegins) {
  EXPECT_NEAR(x_.front()[model::kXPos], 0.0, 1e-3);
  EXPECT_LT(x_.front().tail<model::kNv>().norm(), 0.05);
}

TEST_P(SkateMotion, StaysWithinTheServosAndTheJoints) {
  for (const model::State& x : x_) {
    for (int j = 0; j < model::kNumJoints; ++j) {
      ASSERT_LT(std::abs(x[model::kXJointRate + j]), kMaxReferenceSpeed) << model::kJoints[j].name;
      ASSERT_GT(x[model::kXJoint + j], model::kJoints[j].lower_rad) << model::kJoints[j].name;
      ASSERT_LT(x[model::kXJoint + j], model::kJoints[j].upper_rad) << model::kJoints[j].name;
    }
  }
}

TEST_P(SkateMotion, KeepsItsWheelsOutOfTheGround) {
  for (const model::State& x : x_) ASSERT_GT(above_ground(x, ground_).lowest, -0.004) << x[0];
}

/// Those that never leave the ground.
class RollingMotion : public SkateMotion {};

TEST_P(RollingMotion, KeepsAllWheelsOnTheSurface) {
  for (const model::State& x : x_) {
    ASSERT_GT(above_ground(x, ground_).lowest, -0.0015) << x[0];
    ASSERT_LT(above_ground(x, ground_).highest, 0.0015) << x[0];
  }
}

TEST_P(RollingMotion, KeepsItsPostureAndStandsAlongTheNormal) {
  for (const model::State& x : x_) {
    ASSERT_LT((model::joints(x) - model::joints(x_.front())).cwiseAbs().maxCoeff(), 0.002);
    const math::Vec3 up = math::rotation_matrix(model::base_quat(x)).col(2);
    const double slope = std::atan(ground_slope(ground_, x[model::kXPos]));
    // the axles are 85 mm apart and the trunk is above the surface, not on it: bends come early
    ASSERT_NEAR(std::atan2(up.x(), up.z()), -slope, 0.10) << x[model::kXPos];
  }
}

TEST_P(RollingMotion, GainsWhatItsHeightGivesLessWhatRollingTakes) {
  const Skate& skate = *motion_.skate;
  // the wheels are so fast as the law says; their middle is height_ below the base, normal to it
  const Trajectory wanted = roll(skate, ground_);
  const auto wheels_at = [&](const model::State& x) {
    const BodyPoints points = body_points(x);
    return math::Vec3(points.p_world_foot[0] +
                      points.R_world_foot[0] *
                          math::Vec3(model::kSoleCentreX, 0, model::kSkates.height));
  };
  const auto n = wanted.x.size();
  const auto let_go = static_cast<std::size_t>(skate.push_s / wanted.dt_s);
  const math::Vec3 from = wheels_at(wanted.x[let_go]), to = wheels_at(wanted.x[n - 2]);
  const double v = (wheels_at(wanted.x[n - 1]) - wheels_at(wanted.x[n - 3])).norm() / 0.02;
  const double level = to.x() - from.x();  // friction takes rolling x weight across the slope
  const double energy =
      0.5 * skate.push_m_s * skate.push_m_s + 9.81 * (from.z() - to.z() - skate.rolling * level);
  EXPECT_NEAR(v, std::sqrt(2 * energy), 0.01 * v);
}

TEST_P(SkateMotion, AnEpisodeThatIsTheReferenceSucceeds) {
  MotionEpisode episode;
  episode.completed = true;
  for (const model::State& x : x_) {
    EpisodeSample sample;
    sample.x = x;
    const double load = above_ground(x, ground_).lowest > 0.002 ? 0.0 : 15.0;
    sample.foot_load_N = {load, load};
    episode.samples.push_back(sample);
  }
  for (const auto& result : evaluate(motion_, episode).clauses)
    EXPECT_TRUE(result.holds) << result.text();
  episode.samples.resize(episode.samples.size() / 2);
  EXPECT_FALSE(evaluate(motion_, episode).succeeded());  // does not arrive
}

INSTANTIATE_TEST_SUITE_P(Library, SkateMotion, ::testing::ValuesIn(skate_names()),
                         [](const auto& suite) { return suite.param; });

INSTANTIATE_TEST_SUITE_P(Library, RollingMotion,
                         ::testing::Values("skate_slope", "skate_ramp", "skate_ramp_high"),
                         [](const auto& suite) { return suite.param; });

TEST(SkateJump, FliesAsAStoneWouldFromTheLipToALandingOnAllWheels) {
  const Motion motion = MotionLibrary().load("skate_jump");
  const model::Ground ground = motion.ground();
  const Trajectory wanted = roll(*motion.skate, ground);
  const auto second = [&](std::size_t k, int axis) {
    return (wanted.x[k + 1][axis] - 2 * wanted.x[k][axis] + wanted.x[k - 1][axis]) / 1e-4;
  };
  std::vector<std::size_t> falling;
  for (std::size_t k = 1; k + 1 < wanted.x.size(); ++k)
    if (std::abs(second(k, 2) + 9.81) < 0.1 && std::abs(second(k, 0)) < 0.1) falling.push_back(k);
  ASSERT_GT(falling.size(), 4u);
  EXPECT_EQ(falling.back() - falling.front() + 1, falling.size());  // one flight
  const model::State& first = wanted.x[falling.front()];
  const double up = (wanted.x[falling.front() + 1][2] - wanted.x[falling.front() - 1][2]) / 0.02;
  const double above = first[2] - wanted.x.back()[2];
  const double stone_s = (up + std::sqrt(up * up + 2 * 9.81 * above)) / 9.81;
  EXPECT_NEAR(wanted.dt_s * static_cast<double>(falling.size()), stone_s, 0.02);
  const model::State& last = wanted.x.back();
  EXPECT_LT(std::abs(above_ground(last, ground).lowest), 0.001);
  EXPECT_LT(std::abs(above_ground(last, ground).highest), 0.001);
}

TEST(Skate, AnUnknownNameIsToldWithThoseThereAre) {
  try {
    make_skate("skate_moon");
    FAIL();
  } catch (const MotionError& error) {
    EXPECT_NE(std::string(error.what()).find("skate_ramp"), std::string::npos);
  }
}

}  // namespace
}  // namespace sanso::motion
