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

TEST_P(SkateMotion, KeepsAllWheelsOnTheSurface) {
  for (const model::State& x : x_) {
    const BodyPoints points = body_points(x);
    for (const int side : {kRight, kLeft}) {
      for (const double along : {-1.0, 1.0}) {
        const math::Vec3 p =
            points.p_world_foot[side] +
            points.R_world_foot[side] *
                math::Vec3(model::kSoleCentreX + along * model::kSkates.half_length, 0.0,
                           model::kSkates.height);
        ASSERT_NEAR(p.z(), ground_height(ground_, p.x()), 0.0015) << p.x();
      }
    }
  }
}

TEST_P(SkateMotion, KeepsItsPostureAndStandsAlongTheNormal) {
  for (const model::State& x : x_) {
    ASSERT_LT((model::joints(x) - model::joints(x_.front())).cwiseAbs().maxCoeff(), 0.002);
    const math::Vec3 up = math::rotation_matrix(model::base_quat(x)).col(2);
    const double slope = std::atan(ground_slope(ground_, x[model::kXPos]));
    // the axles are 85 mm apart and the trunk is above the surface, not on it: bends come early
    ASSERT_NEAR(std::atan2(up.x(), up.z()), -slope, 0.10) << x[model::kXPos];
  }
}

TEST_P(SkateMotion, GainsWhatItsHeightGivesLessWhatRollingTakes) {
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
    sample.foot_load_N = {15.0, 15.0};
    episode.samples.push_back(sample);
  }
  for (const auto& result : evaluate(motion_, episode).clauses)
    EXPECT_TRUE(result.holds) << result.text();
  episode.samples.resize(episode.samples.size() / 2);
  EXPECT_FALSE(evaluate(motion_, episode).succeeded());  // does not arrive
}

INSTANTIATE_TEST_SUITE_P(Library, SkateMotion, ::testing::ValuesIn(skate_names()),
                         [](const auto& suite) { return suite.param; });

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
