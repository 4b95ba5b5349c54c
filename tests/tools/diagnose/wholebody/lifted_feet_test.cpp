// A sole is in the air where attitude and joints take it above the other, wherever the base is.
#include "tools/diagnose/wholebody/lifted_feet.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/tools/diagnose/wholebody/made_stance.h"
#include "tools/diagnose/wholebody/drive_track.h"

namespace sanso::diagnose {
namespace {

using namespace test;

class LiftedFeet : public ::testing::Test {
 protected:
  LiftedFeet() : world_({.recordings = 1, .seconds = 1.0}) {
    recording().attitude = true;
    recording().q.setZero();
  }
  WholeRecording& recording() { return world_.recordings.front(); }
  std::vector<std::vector<int>> lifted() const {
    return lifted_feet(world_.asking(), world_.recordings.front());
  }
  int joint(const char* name) const { return world_.body.model.tree.index_of(name); }
  /// Bends a knee in rows [a, b), thigh and sole staying as upright as they may.
  void lift(const char* side, std::size_t a, std::size_t b, double bent) {
    const std::string s = side;
    for (std::size_t k = a; k < b; ++k) {
      const auto col = static_cast<Eigen::Index>(k);
      const double sign = s == "l" ? 1.0 : -1.0;  // axes of the two legs are mirrored
      recording().q(joint((s + "_hip_pitch").c_str()), col) = -sign * bent;
      recording().q(joint((s + "_knee").c_str()), col) = 2.0 * sign * bent;
      recording().q(joint((s + "_ank_pitch").c_str()), col) = sign * bent;
    }
  }

  StanceWorld world_;
};

TEST_F(LiftedFeet, NobodyIsWhereBothStand) {
  for (const std::vector<int>& row : lifted()) EXPECT_TRUE(row.empty());
}

TEST_F(LiftedFeet, TheBentLegIs) {
  lift("l", 20, 60, 0.5);
  const std::vector<std::vector<int>> rows = lifted();
  ASSERT_EQ(rows.size(), recording().rows());
  EXPECT_TRUE(rows[10].empty());
  EXPECT_EQ(rows[40], std::vector<int>{joint("l_ank_roll")});
}

TEST_F(LiftedFeet, AWorldThatIsTurnedChangesNothing) {
  lift("r", 0, recording().rows(), 0.5);
  const M3 heading = Eigen::AngleAxisd(1.1, V3::UnitZ()).toRotationMatrix();
  for (M3& R : recording().R) R = heading;
  for (V3& p : recording().p) p = V3(3.0, -2.0, 0.7);
  EXPECT_EQ(lifted()[40], std::vector<int>{joint("r_ank_roll")});
}

TEST_F(LiftedFeet, ATrunkThatLeansLiftsTheOtherSole) {
  const M3 lean = Eigen::AngleAxisd(0.3, V3::UnitX()).toRotationMatrix();
  for (M3& R : recording().R) R = lean;
  EXPECT_EQ(lifted()[40], std::vector<int>{joint("l_ank_roll")}) << "left of x is up";
}

TEST_F(LiftedFeet, ASensorKnowsBetterAndWithoutAttitudeNobodyDoes) {
  lift("l", 0, recording().rows(), 0.5);
  recording().feet = {{"l", joint("l_ank_roll"), std::vector<double>(recording().rows(), 10.0)}};
  EXPECT_TRUE(lifted().empty());
  recording().feet.clear(), recording().attitude = false;
  EXPECT_TRUE(lifted().empty());
}

TEST_F(LiftedFeet, AWindowHasThemInTheAirAllAlongOrNotAtAll) {
  lift("l", 20, 60, 0.5);
  const Asking asking = world_.asking();
  const Track track = track_of(asking, recording());
  const std::vector<int> left{joint("l_ank_roll")};
  EXPECT_EQ(window_of(asking, track, 30, 40).in_air, left);
  EXPECT_TRUE(window_of(asking, track, 15, 25).in_air.empty());
  EXPECT_TRUE(impact_near(track, 15, 25)) << "it comes off";
  EXPECT_TRUE(impact_near(track, 60, 70)) << "it has just come down";
  EXPECT_TRUE(impact_near(track, 65, 75)) << "beside it";
  EXPECT_FALSE(impact_near(track, 35, 45));
  EXPECT_FALSE(impact_near(track, 85, 95));
}

}  // namespace
}  // namespace sanso::diagnose
